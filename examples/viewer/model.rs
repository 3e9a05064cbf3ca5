//! The model on show: opened from the command line, or dropped onto the window.
//!
//! In: [`Open`] messages and dropped files. Out: one [`Model`] entity with the mesh (or a glTF scene below it), and a
//! [`Notice`] when a file cannot be read; the model before stays then.

use std::{
    fs,
    path::{Path, PathBuf},
};

use bevy::{
    asset::RecursiveDependencyLoadState, prelude::*, window::FileDragAndDrop, world_serialization::WorldAssetRoot,
};

use crate::{
    common::{
        gltf::register_scene_types,
        mesh_file::{self, RawMesh},
        scene::Subject,
        shapes,
    },
    settings::{Field, ViewerSettings},
    styles::add_stress,
};

/// Opens models.
pub struct ModelPlugin {
    /// What is shown first.
    pub open: Open,
}

impl Plugin for ModelPlugin {
    fn build(&self, app: &mut App) {
        register_scene_types(app);
        app.add_message::<Open>()
            .init_resource::<Notice>()
            .add_systems(Update, (take_dropped_files, open, watch_scene, play).chain());
        app.world_mut().write_message(self.open.clone());
    }
}

/// A request to show another model.
#[derive(Message, Clone, Debug)]
pub enum Open {
    /// The built-in model.
    Knot,
    /// A mesh that is read already.
    Mesh {
        /// Name to show.
        name: String,
        /// The mesh, in the order of its file.
        mesh: RawMesh,
    },
    /// A glTF or GLB file, by its absolute path or by that in the folder of assets.
    Scene(PathBuf),
}

impl Open {
    /// Reads `path`, or leaves it to Bevy when it is glTF.
    pub fn file(path: &Path) -> Result<Self, String> {
        let name = path
            .file_name()
            .unwrap_or(path.as_os_str())
            .to_string_lossy()
            .into_owned();
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        if ending == "gltf" || ending == "glb" {
            // Absolute, for Bevy looks for relative paths in its folder of assets.
            let path =
                fs::canonicalize(path).map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
            return Ok(Self::Scene(path));
        }
        let mesh = mesh_file::read(path).map_err(|error| error.to_string())?;
        Ok(Self::Mesh { name, mesh })
    }
}

/// The model on show.
#[derive(Component, Debug)]
pub struct Model {
    /// Name to show.
    pub name: String,
    /// Vertices of its file in the file's order, which a field file has to match; `None` for glTF.
    pub vertices: Option<usize>,
    /// The material of a model whose file has none; `None` for glTF.
    pub material: Option<Handle<StandardMaterial>>,
}

/// What went wrong last, for the panel.
#[derive(Resource, Default, Debug)]
pub struct Notice(pub Option<String>);

fn take_dropped_files(
    mut drops: MessageReader<FileDragAndDrop>,
    mut open: MessageWriter<Open>,
    mut settings: ResMut<ViewerSettings>,
    mut notice: ResMut<Notice>,
) {
    for drop in drops.read() {
        let FileDragAndDrop::DroppedFile { path_buf: path, .. } = drop else {
            continue;
        };
        if path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("txt"))
        {
            settings.field = Field::File(path.clone());
            settings.symmetry = settings.field.symmetry();
            continue;
        }
        notice.0 = Open::file(path)
            .map(|request| {
                open.write(request);
            })
            .err();
    }
}

fn open(
    mut requests: MessageReader<Open>,
    shown: Query<Entity, With<Model>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    server: Res<AssetServer>,
    mut commands: Commands,
) {
    let Some(request) = requests.read().last() else { return };
    for entity in &shown {
        commands.entity(entity).despawn();
    }
    let mut spawn_mesh = |name: &str, raw: &RawMesh| {
        let material = materials.add(StandardMaterial {
            perceptual_roughness: 0.45,
            ..default()
        });
        let mut mesh = mesh_file::to_bevy_mesh(raw);
        add_stress(&mut mesh);
        commands.spawn((
            Subject,
            Model {
                name: name.into(),
                vertices: Some(raw.positions.len()),
                material: Some(material.clone()),
            },
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(material),
        ));
    };
    match request {
        Open::Knot => spawn_mesh("knot", &shapes::knot(480, 42)),
        Open::Mesh { name, mesh } => spawn_mesh(name, mesh),
        Open::Scene(path) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let scene = server.load(GltfAssetLabel::Scene(0).from_asset(path.clone()));
            commands.spawn((
                Subject,
                Model {
                    name,
                    vertices: None,
                    material: None,
                },
                WorldAssetRoot(scene),
            ));
        }
    }
}

/// Plays the first animation of a scene that has one.
fn play(
    mut players: Query<(Entity, &mut AnimationPlayer), Added<AnimationPlayer>>,
    scene: Query<&WorldAssetRoot, With<Model>>,
    server: Res<AssetServer>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    mut commands: Commands,
) {
    let path = scene.iter().next().and_then(|root| server.get_path(&root.0));
    let Some(path) = path else { return };
    for (entity, mut player) in &mut players {
        let clip = server.load(GltfAssetLabel::Animation(0).from_asset(path.without_label().into_owned()));
        let (graph, node) = AnimationGraph::from_clip(clip);
        player.play(node).repeat();
        commands.entity(entity).insert(AnimationGraphHandle(graphs.add(graph)));
    }
}

/// Says so when Bevy could not load a scene.
fn watch_scene(scene: Query<&WorldAssetRoot, With<Model>>, server: Res<AssetServer>, mut notice: ResMut<Notice>) {
    for root in &scene {
        if let Some(RecursiveDependencyLoadState::Failed(error)) = server.get_recursive_dependency_load_state(&root.0) {
            // Bevy may append a stack trace.
            let message = error.to_string().lines().next().map(str::to_owned);
            if notice.0 != message {
                notice.0 = message;
            }
        }
    }
}
