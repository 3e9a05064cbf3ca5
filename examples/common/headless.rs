//! Renders without a window: an [`App`] that is driven by hand, a condition for "everything is there", a picture.
//!
//! In: plugins and systems that the caller adds to [`headless_app`]. Out: what the cameras draw, as an [`Image`].
//! Frames are deterministic: one thread drives the app, pipelines compile before they are used, and each update
//! advances time by [`FRAME_TIME`]. Errors are sentences for the user. Examples and tests share this file.

use std::{
    any::Any,
    panic::{self, AssertUnwindSafe},
    path::Path,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{self, TryRecvError},
    },
    time::{Duration, Instant},
};

use bevy::{
    app::PluginsState,
    asset::{RecursiveDependencyLoadState, UnapprovedPathMode, UntypedAssetId},
    camera::RenderTarget,
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        RenderApp, RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_asset::RenderAssets,
        render_resource::{CachedPipelineState, PipelineCache, TextureFormat, TextureUsages},
        renderer::initialize_renderer,
        settings::{RenderCreation, RenderResources, WgpuSettings},
        storage::{GpuShaderBuffer, ShaderBuffer},
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    shader::ShaderCacheError,
    time::TimeUpdateStrategy,
    window::ExitCondition,
    winit::WinitPlugin,
    world_serialization::WorldAssetRoot,
};

use super::gltf::gltf_plugin;

/// Time that passes for the app in one update.
pub const FRAME_TIME: Duration = Duration::from_millis(16);

/// Real time after which [`wait_until_ready`] and [`capture`] give up.
const PATIENCE: Duration = Duration::from_secs(180);

/// The image that every camera without an image of its own draws to.
#[derive(Resource, Clone, Debug)]
pub struct HeadlessTarget(pub Handle<Image>);

/// Further conditions of [`wait_until_ready`], asked after every update.
#[derive(Resource, Default)]
pub struct ReadyChecks(pub Vec<ReadyCheck>);

/// Gives what is still missing in one word or two, `None` when all is there, an error when it will never be there.
pub type ReadyCheck = fn(&mut World) -> Result<Option<String>, String>;

/// An app with Bevy's default plugins, but no window, whose cameras draw to an image of `size` pixels.
///
/// The caller adds plugins and systems and then calls [`wait_until_ready`].
///
/// # Errors
///
/// There is no usable GPU driver, see [`probe_gpu`].
pub fn headless_app(size: UVec2) -> Result<App, String> {
    let renderer = open_gpu()?;
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                render_creation: RenderCreation::Manual(renderer),
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .set(AssetPlugin {
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            })
            .set(gltf_plugin())
            .set(LogPlugin {
                level: Level::WARN,
                // What a software renderer lacks is no news here.
                filter: "wgpu=error,naga=warn,bevy_render=error,bevy_pbr=error".into(),
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>(),
    )
    .insert_resource(TimeUpdateStrategy::ManualDuration(FRAME_TIME))
    .init_resource::<ReadyChecks>()
    .add_observer(redirect_camera);

    let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.insert_resource(HeadlessTarget(target));
    Ok(app)
}

/// Cameras draw to the primary window unless told otherwise; there is none here.
fn redirect_camera(
    added: On<Add, RenderTarget>,
    targets: Query<&RenderTarget>,
    headless: Res<HeadlessTarget>,
    mut commands: Commands,
) {
    if let Ok(RenderTarget::Window(_)) = targets.get(added.entity) {
        commands
            .entity(added.entity)
            .insert(RenderTarget::Image(headless.0.clone().into()));
    }
}

/// Says whether Bevy will find a GPU driver, for Bevy itself panics where there is none.
///
/// # Errors
///
/// A sentence that names the package to install.
pub fn probe_gpu() -> Result<(), String> {
    open_gpu().map(drop)
}

/// Does what Bevy's `RenderPlugin` does, but with an error for its panic.
fn open_gpu() -> Result<RenderResources, String> {
    // The hook is the process's: two tests must not exchange it at once.
    static HOOK: Mutex<()> = Mutex::new(());

    let settings = WgpuSettings::default();
    let backends = settings.backends.ok_or("WGPU_BACKEND names no graphics interface")?;
    let guard = HOOK.lock().unwrap_or_else(PoisonError::into_inner);
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let opened = panic::catch_unwind(AssertUnwindSafe(|| {
        bevy::tasks::block_on(initialize_renderer(backends, None, &settings))
    }));
    panic::set_hook(hook);
    drop(guard);
    opened.map_err(|panic| {
        let message = panic_message(&*panic);
        if message.contains("Unable to find a GPU") {
            "no GPU driver was found; install one for Vulkan (on Debian and Ubuntu: apt-get install \
             mesa-vulkan-drivers, which also draws without a GPU)"
                .to_owned()
        } else {
            format!(
                "the GPU could not be opened: {}",
                message.lines().next().unwrap_or_default()
            )
        }
    })
}

fn panic_message(panic: &(dyn Any + Send)) -> &str {
    match (panic.downcast_ref::<String>(), panic.downcast_ref::<&str>()) {
        (Some(message), _) => message,
        (_, Some(message)) => message,
        _ => "unknown cause",
    }
}

/// Runs one update; the first one builds the app.
///
/// # Errors
///
/// The app asked to exit, as Bevy's renderer does after a validation error (which is then in the log).
pub fn update(app: &mut App) -> Result<(), String> {
    if app.plugins_state() != PluginsState::Cleaned {
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
    }
    app.update();
    match app.should_exit() {
        Some(exit) => Err(format!("the renderer stopped ({exit:?}); the log says why")),
        None => Ok(()),
    }
}

/// Updates the app until what it shows is complete: assets loaded, storage buffers on the GPU, pipelines compiled and no
/// new ones for three updates, and all [`ReadyChecks`] content.
///
/// # Errors
///
/// A shader does not compile (Bevy draws nothing then and goes on), an asset is not to be had, the renderer stopped, a
/// [`ReadyCheck`] failed, or all this took more than three minutes.
pub fn wait_until_ready(app: &mut App) -> Result<(), String> {
    const STEADY_UPDATES: u32 = 3;
    let begin = Instant::now();
    let (mut steady, mut pipelines) = (0, 0);
    while steady < STEADY_UPDATES {
        update(app)?;
        let before = std::mem::replace(&mut pipelines, count_pipelines(app)?);
        let missing = match missing(app)? {
            None if before != pipelines => Some("new pipelines".to_owned()),
            missing => missing,
        };
        steady = if missing.is_none() { steady + 1 } else { 0 };
        if let Some(missing) = missing.filter(|_| begin.elapsed() > PATIENCE) {
            return Err(format!(
                "not ready after {} s: waiting for {missing}",
                PATIENCE.as_secs()
            ));
        }
    }
    Ok(())
}

/// How many pipelines there are, compiled or not.
fn count_pipelines(app: &App) -> Result<usize, String> {
    let cache = pipeline_cache(app)?;
    let errors: Vec<_> = cache
        .pipelines()
        .filter_map(|pipeline| pipeline_error(&pipeline.state))
        .collect();
    if errors.is_empty() {
        Ok(cache.pipelines().count())
    } else {
        Err(format!("{} pipelines failed:\n{}", errors.len(), errors.join("\n")))
    }
}

fn pipeline_error(state: &CachedPipelineState) -> Option<String> {
    match state {
        // These two are tried again in the next update.
        CachedPipelineState::Err(
            ShaderCacheError::ShaderNotLoaded(_) | ShaderCacheError::ShaderImportNotYetAvailable,
        ) => None,
        CachedPipelineState::Err(error) => Some(error.to_string()),
        _ => None,
    }
}

fn pipeline_cache(app: &App) -> Result<&PipelineCache, String> {
    let render_app = app.get_sub_app(RenderApp).ok_or("Bevy has no renderer")?;
    render_app
        .world()
        .get_resource()
        .ok_or_else(|| "Bevy's renderer did not start".to_owned())
}

/// The first thing found that is not there yet.
fn missing(app: &mut App) -> Result<Option<String>, String> {
    if pipeline_cache(app)?.waiting_pipelines().next().is_some() {
        return Ok(Some("pipelines to compile".into()));
    }
    if !buffers_are_on_gpu(app) {
        return Ok(Some("storage buffers".into()));
    }
    if let Some(asset) = missing_asset(app.world_mut())? {
        return Ok(Some(asset));
    }
    let checks = app.world().resource::<ReadyChecks>().0.clone();
    for check in checks {
        if let Some(missing) = check(app.world_mut())? {
            return Ok(Some(missing));
        }
    }
    Ok(None)
}

/// A material whose storage buffer is not on the GPU yet is not drawn, in silence.
fn buffers_are_on_gpu(app: &App) -> bool {
    let Some(on_gpu) = app
        .sub_app(RenderApp)
        .world()
        .get_resource::<RenderAssets<GpuShaderBuffer>>()
    else {
        return true;
    };
    let buffers = app.world().get_resource::<Assets<ShaderBuffer>>();
    buffers.is_none_or(|buffers| buffers.ids().all(|id| on_gpu.get(id).is_some()))
}

fn missing_asset(world: &mut World) -> Result<Option<String>, String> {
    let mut ids: Vec<UntypedAssetId> = world
        .query::<&Mesh3d>()
        .iter(world)
        .map(|mesh| mesh.id().into())
        .collect();
    let mut materials = world.query::<&MeshMaterial3d<StandardMaterial>>();
    ids.extend(
        materials
            .iter(world)
            .map(|material| UntypedAssetId::from(material.id())),
    );
    let mut scenes = world.query::<&WorldAssetRoot>();
    ids.extend(scenes.iter(world).map(|scene| UntypedAssetId::from(scene.0.id())));

    let server = world.resource::<AssetServer>();
    for id in ids {
        // `None`: made in the program, not loaded from a file.
        match server.get_recursive_dependency_load_state(id) {
            None | Some(RecursiveDependencyLoadState::Loaded) => {}
            Some(RecursiveDependencyLoadState::Failed(error)) => {
                // Bevy may append a stack trace.
                return Err(error.to_string().lines().next().unwrap_or_default().to_owned());
            }
            Some(_) => {
                let path = server
                    .get_path(id)
                    .map_or_else(|| id.to_string(), |path| path.to_string());
                return Ok(Some(path));
            }
        }
    }
    Ok(None)
}

/// What the cameras drew to `target` in the next update, as sRGB with 8 bits per channel.
///
/// # Errors
///
/// The renderer stopped, or `target` is no image on the GPU.
pub fn capture(app: &mut App, target: &Handle<Image>) -> Result<Image, String> {
    let (sender, receiver) = mpsc::channel();
    // An observer must be `Sync`.
    let sender = Arc::new(Mutex::new(sender));
    app.world_mut()
        .spawn(Screenshot::image(target.clone()))
        .observe(move |captured: On<ScreenshotCaptured>| {
            let sender = sender.lock().unwrap_or_else(PoisonError::into_inner);
            // The receiver is gone when `capture` gave up.
            let _ = sender.send(captured.image.clone());
        });
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        update(app)?;
        match receiver.try_recv() {
            Ok(image) => return Ok(image),
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => break,
        }
    }
    Err("the picture could not be read back from the GPU".into())
}

/// Waits until the app is ready and captures its [`HeadlessTarget`].
///
/// # Errors
///
/// See [`wait_until_ready`] and [`capture`].
pub fn picture(app: &mut App) -> Result<Image, String> {
    wait_until_ready(app)?;
    let target = app.world().resource::<HeadlessTarget>().0.clone();
    capture(app, &target)
}

/// Whether all pixels are the same: nothing was drawn.
pub fn is_blank(image: &Image) -> bool {
    let data = image.data.as_deref().unwrap_or_default();
    let (pixels, _) = data.as_chunks::<4>();
    pixels.windows(2).all(|pair| pair[0] == pair[1])
}

/// Writes `image` as PNG, without its alpha channel.
///
/// # Errors
///
/// The file cannot be written, or its name does not end in `.png`.
pub fn save_png(image: &Image, path: &Path) -> Result<(), String> {
    if path
        .extension()
        .is_none_or(|extension| !extension.eq_ignore_ascii_case("png"))
    {
        return Err(format!("{}: the name of a picture must end in .png", path.display()));
    }
    let picture = image.clone().try_into_dynamic().map_err(|error| error.to_string())?;
    picture
        .to_rgb8()
        .save(path)
        .map_err(|error| format!("{}: cannot be written: {error}", path.display()))
}
