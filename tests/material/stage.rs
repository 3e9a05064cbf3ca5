//! A headless app that draws one small scene after the other, and fails if a pipeline does not compile.
#![allow(dead_code, reason = "each test uses a part of it")]

use bevy::{
    app::{PluginGroupBuilder, Plugins, PluginsState},
    camera::{Hdr, RenderTarget},
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    mesh::MeshTag,
    prelude::*,
    render::{
        RenderApp, RenderPlugin,
        gpu_readback::{Readback, ReadbackComplete},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::{CachedPipelineState, PipelineCache, TextureFormat, TextureUsages},
    },
    shader::ShaderCacheError,
    time::TimeUpdateStrategy,
    window::ExitCondition,
    winit::WinitPlugin,
};
use std::{path::Path, time::Duration};

/// A picture in linear colours.
pub struct Picture {
    pub width: usize,
    pub pixels: Vec<Vec4>,
}

impl Picture {
    pub fn at(&self, x: usize, y: usize) -> Vec4 {
        self.pixels[y * self.width + x]
    }

    pub fn luminance(&self) -> Vec<f32> {
        self.pixels
            .iter()
            .map(|p| p.truncate().dot(Vec3::new(0.2126, 0.7152, 0.0722)))
            .collect()
    }

    pub fn mean(&self) -> Vec4 {
        self.pixels.iter().sum::<Vec4>() / self.pixels.len() as f32
    }

    /// Standard deviation of the luminance.
    pub fn contrast(&self) -> f32 {
        let values = self.luminance();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt()
    }

    pub fn max_difference(&self, other: &Self) -> f32 {
        self.pixels
            .iter()
            .zip(&other.pixels)
            .map(|(a, b)| (*a - *b).abs().max_element())
            .fold(0.0, f32::max)
    }

    /// Writes a PNG into the directory `PATTERN_PICTURES`, if that is set.
    pub fn save(&self, name: &str) {
        let Ok(directory) = std::env::var("PATTERN_PICTURES") else {
            return;
        };
        let srgb = |v: f32| {
            let v = v.clamp(0.0, 1.0);
            let s = if v <= 0.003_130_8 {
                12.92 * v
            } else {
                1.055 * v.powf(1.0 / 2.4) - 0.055
            };
            (255.0 * s).round() as u8
        };
        let bytes: Vec<u8> = self
            .pixels
            .iter()
            .flat_map(|p| [srgb(p.x), srgb(p.y), srgb(p.z), 255])
            .collect();
        let image = Image::new(
            bevy::render::render_resource::Extent3d {
                width: self.width as u32,
                height: (self.pixels.len() / self.width) as u32,
                depth_or_array_layers: 1,
            },
            bevy::render::render_resource::TextureDimension::D2,
            bytes,
            TextureFormat::Rgba8UnormSrgb,
            default(),
        );
        let path = Path::new(&directory).join(format!("{name}.png"));
        image.try_into_dynamic().unwrap().to_rgb8().save(path).unwrap();
    }
}

/// What a scene is drawn with.
#[derive(Clone, Copy)]
pub struct Lens {
    pub width: u32,
    pub height: u32,
    pub from: Vec3,
    pub to: Vec3,
    /// Height of an orthographic view; `None`: perspective of 45 degrees.
    pub orthographic: Option<f32>,
    pub msaa: Msaa,
    pub hdr: bool,
}

impl Default for Lens {
    fn default() -> Self {
        Self {
            width: 96,
            height: 64,
            from: Vec3::new(0.0, 0.0, 3.0),
            to: Vec3::ZERO,
            orthographic: None,
            msaa: Msaa::Off,
            hdr: true,
        }
    }
}

#[derive(Resource, Default)]
struct Received(Option<Vec<u8>>);

pub struct Stage {
    pub app: App,
}

fn headless_plugins() -> PluginGroupBuilder {
    DefaultPlugins
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..default()
        })
        .disable::<WinitPlugin>()
        .disable::<PipelinedRenderingPlugin>()
}

impl Stage {
    pub fn new<M>(plugins: impl Plugins<M>) -> Self {
        let mut app = App::new();
        app.add_plugins(headless_plugins())
            .add_plugins(plugins)
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(16)))
            .insert_resource(ClearColor(Color::BLACK))
            .insert_resource(DirectionalLightShadowMap { size: 1024 })
            .init_resource::<Received>();
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        Self { app }
    }

    pub fn add<A: Asset>(&mut self, asset: A) -> Handle<A> {
        self.app.world_mut().resource_mut::<Assets<A>>().add(asset)
    }

    /// An entity with a mesh, a material and the pattern at `tag`.
    pub fn body<M: Material>(&mut self, mesh: &Handle<Mesh>, material: &Handle<M>, tag: u32, at: Transform) -> Entity {
        let parts = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), MeshTag(tag), at);
        self.app.world_mut().spawn(parts).id()
    }

    /// An entity with a mesh and the pattern at `tag`, without a material.
    pub fn bare(&mut self, mesh: &Handle<Mesh>, tag: u32, at: Transform) -> Entity {
        self.app
            .world_mut()
            .spawn((Mesh3d(mesh.clone()), MeshTag(tag), at))
            .id()
    }

    /// A camera that looks into an own picture.
    pub fn camera(&mut self, lens: Lens) -> (Entity, Handle<Image>) {
        let format = if lens.hdr {
            TextureFormat::Rgba16Float
        } else {
            TextureFormat::Rgba8UnormSrgb
        };
        let mut image = Image::new_target_texture(lens.width, lens.height, format, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = self.add(image);
        let projection = match lens.orthographic {
            Some(height) => Projection::Orthographic(OrthographicProjection {
                scaling_mode: bevy::camera::ScalingMode::FixedVertical {
                    viewport_height: height,
                },
                ..OrthographicProjection::default_3d()
            }),
            None => Projection::Perspective(PerspectiveProjection::default()),
        };
        let mut camera = self.app.world_mut().spawn((
            Camera3d::default(),
            RenderTarget::Image(target.clone().into()),
            projection,
            Tonemapping::None,
            DebandDither::Disabled,
            lens.msaa,
            Transform::from_translation(lens.from).looking_at(lens.to, Vec3::Y),
        ));
        if lens.hdr {
            camera.insert(Hdr);
        }
        (camera.id(), target)
    }

    /// Runs until all pipelines are there; panics with the messages of those that did not compile.
    pub fn settle(&mut self) {
        let (mut count, mut calm) = (0, 0);
        for _ in 0..200 {
            self.app.update();
            assert!(
                self.app.should_exit().is_none(),
                "the renderer stopped: a validation error"
            );
            let cache = self.app.sub_app(RenderApp).world().resource::<PipelineCache>();
            let errors: Vec<String> = cache
                .pipelines()
                .filter_map(|pipeline| match &pipeline.state {
                    // Still waiting for a file.
                    CachedPipelineState::Err(
                        ShaderCacheError::ShaderNotLoaded(_) | ShaderCacheError::ShaderImportNotYetAvailable,
                    ) => None,
                    CachedPipelineState::Err(error) => Some(format!("{error}\n{error:?}")),
                    _ => None,
                })
                .collect();
            assert!(errors.is_empty(), "pipelines failed:\n{}", errors.join("\n"));
            let now = cache.pipelines().count();
            calm = if cache.waiting_pipelines().count() == 0 && now == count {
                calm + 1
            } else {
                0
            };
            count = now;
            if calm >= 3 {
                return;
            }
        }
        panic!("the pipelines are not ready after 200 frames");
    }

    /// The picture of a camera that is already there.
    pub fn read(&mut self, target: &Handle<Image>) -> Picture {
        self.app.world_mut().resource_mut::<Received>().0 = None;
        let reader = self
            .app
            .world_mut()
            .spawn(Readback::texture(target.clone()))
            .observe(|event: On<ReadbackComplete>, mut received: ResMut<Received>| {
                received.0 = Some(event.data.clone());
            })
            .id();
        for _ in 0..10 {
            self.app.update();
            if self.app.world().resource::<Received>().0.is_some() {
                break;
            }
        }
        self.app.world_mut().despawn(reader);
        let data = self
            .app
            .world_mut()
            .resource_mut::<Received>()
            .0
            .take()
            .expect("no picture came back");
        let image = self.app.world().resource::<Assets<Image>>().get(target).unwrap();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let half_float = image.texture_descriptor.format == TextureFormat::Rgba16Float;
        let pixel = if half_float { 8 } else { 4 };
        let row = (width * pixel).next_multiple_of(256);
        let row = if data.len() == width * height * pixel {
            width * pixel
        } else {
            row
        };
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let bytes = &data[y * row + x * pixel..][..pixel];
                pixels.push(if half_float {
                    Vec4::from_array(std::array::from_fn(|c| {
                        half(u16::from_le_bytes([bytes[2 * c], bytes[2 * c + 1]]))
                    }))
                } else {
                    let linear = |v: u8| Srgba::gamma_function(f32::from(v) / 255.0);
                    Vec4::new(
                        linear(bytes[0]),
                        linear(bytes[1]),
                        linear(bytes[2]),
                        f32::from(bytes[3]) / 255.0,
                    )
                });
            }
        }
        Picture { width, pixels }
    }

    /// One picture of the scene as it is.
    pub fn picture(&mut self, lens: Lens) -> Picture {
        let (camera, target) = self.camera(lens);
        self.settle();
        let picture = self.read(&target);
        self.app.world_mut().despawn(camera);
        picture
    }

    pub fn clear(&mut self, entities: impl IntoIterator<Item = Entity>) {
        for entity in entities {
            self.app.world_mut().despawn(entity);
        }
    }

    /// A sun, with shadows or without.
    pub fn sun(&mut self, from: Vec3, shadow_maps_enabled: bool) -> Entity {
        self.app
            .world_mut()
            .spawn((
                DirectionalLight {
                    illuminance: 3_000.0,
                    shadow_maps_enabled,
                    ..default()
                },
                CascadeShadowConfigBuilder {
                    num_cascades: 1,
                    maximum_distance: 12.0,
                    ..default()
                }
                .build(),
                Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Z),
            ))
            .id()
    }
}

/// IEEE half to single precision.
fn half(bits: u16) -> f32 {
    let sign = if bits & 0x8000 != 0 { -1.0 } else { 1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f);
    let mantissa = f32::from(bits & 0x3ff);
    sign * match exponent {
        0 => mantissa * 2.0_f32.powi(-24),
        31 => f32::INFINITY,
        _ => (1.0 + mantissa / 1024.0) * 2.0_f32.powi(exponent - 15),
    }
}
