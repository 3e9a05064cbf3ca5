//! Buffers that a user's own compute pass writes: directions and frequencies read from them, and errors.

use crate::{
    common::{self, add_mesh, app, graph, share_off, update, wave},
    fields::{near, spawn, torus},
};
use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::schedule::camera_driver,
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        render_resource::BufferUsages,
        renderer::{RenderContext, RenderGraph, RenderGraphSystems},
        storage::{GpuShaderBuffer, ShaderBuffer},
    },
};
use bevy_field_patterns::{
    field::*,
    prelude::*,
    wave::{Pattern, PatternRenderSystems},
};

/// A few frames, once the graph is there: what never sleeps does not settle.
fn wait(app: &mut App, entity: Entity) {
    let mut frames = 0;
    while !app.world().entity(entity).contains::<Pattern>() {
        update(app);
        std::thread::sleep(std::time::Duration::from_millis(1));
        frames += 1;
        assert!(frames < 5000);
    }
    (0..4).for_each(|_| update(app));
}

/// A buffer of a user, and the one that the user's pass fills it from.
#[derive(Resource, Clone)]
struct Passed {
    from: Handle<ShaderBuffer>,
    to: Handle<ShaderBuffer>,
}

fn pass(mut context: RenderContext, passed: Res<Passed>, buffers: Res<RenderAssets<GpuShaderBuffer>>) {
    if let (Some(from), Some(to)) = (buffers.get(&passed.from), buffers.get(&passed.to)) {
        let size = from.buffer.size();
        context
            .command_encoder()
            .copy_buffer_to_buffer(&from.buffer, 0, &to.buffer, 0, size);
    }
}

#[test]
fn buffers_are_read_after_the_users_pass_of_the_same_frame() {
    let raw = torus();
    let mut app = app();
    let add = |app: &mut App, data: Vec<u8>, usage: BufferUsages| {
        let mut buffer = ShaderBuffer::new(&data, RenderAssetUsages::default());
        buffer.buffer_description.usage |= usage;
        app.world_mut().resource_mut::<Assets<ShaderBuffer>>().add(buffer)
    };
    let vectors = |angle: f32| -> Vec<Vec4> {
        let turn = Quat::from_rotation_z(angle);
        raw.positions
            .iter()
            .map(|p| (3.0 * (turn * *p + Vec3::X)).extend(f32::NAN))
            .collect()
    };
    let frequencies = |shift: f32| -> Vec<f32> { raw.positions.iter().map(|p| 4.0 + shift * p.x).collect() };
    let bytes = |v: &[Vec4]| bytemuck::cast_slice(v).to_vec();
    let from = add(&mut app, bytes(&vectors(0.0)), BufferUsages::COPY_SRC);
    let to = add(&mut app, vec![0; 16 * raw.positions.len()], BufferUsages::COPY_DST);
    let f = add(
        &mut app,
        bytemuck::cast_slice(&frequencies(1.0)).to_vec(),
        BufferUsages::empty(),
    );
    let passed = Passed {
        from: from.clone(),
        to: to.clone(),
    };
    let render = app.sub_app_mut(RenderApp);
    render.insert_resource(passed).add_systems(
        RenderGraph,
        pass.in_set(RenderGraphSystems::Render)
            .before(PatternRenderSystems)
            .before(camera_driver),
    );
    let spawned = (
        Mesh3d(add_mesh(&mut app, &raw)),
        DirectionField::Buffer(to.clone().into()),
        Symmetry::Vector,
        Frequency::Buffer(FieldBuffer {
            buffer: f.clone(),
            live: false,
        }),
    );
    let entity = app.world_mut().spawn(spawned).id();
    wait(&mut app, entity);
    let graph = graph(&app, entity);
    let twin = |angle: f32| {
        let vectors: Vec<Vec3> = vectors(angle).iter().map(|v| v.truncate()).collect();
        directions(
            &DirectionField::Vertices(vectors.into()),
            Symmetry::Vector,
            0.0,
            &graph,
            &common::mesh_file::to_bevy_mesh(&raw),
        )
        .unwrap()
    };
    let near_frequencies = |app: &App, shift: f32| {
        let ids = graph.first_vertices();
        let wanted = frequencies(shift);
        let (_, f, _) = wave(app, entity);
        assert!(f.iter().zip(&ids).all(|(f, &id)| *f == wanted[id as usize]));
    };
    near(&app, entity, &twin(0.0), 1);
    near_frequencies(&app, 1.0);
    let write = |app: &mut App, handle: &Handle<ShaderBuffer>, data: Vec<u8>| {
        let mut buffers = app.world_mut().resource_mut::<Assets<ShaderBuffer>>();
        buffers.get_mut(handle).unwrap().data = Some(data);
    };
    for angle in [0.5, 1.0] {
        write(&mut app, &from, bytes(&vectors(angle)));
        // Read only on demand.
        write(&mut app, &f, bytemuck::cast_slice(&frequencies(angle)).to_vec());
        update(&mut app);
        near(&app, entity, &twin(angle), 1);
        let off = share_off(&twin(angle), &twin(angle - 0.5), &graph, 1);
        assert!(off > 0.5, "the comparison can fail: {off}");
    }
    near_frequencies(&app, 1.0);
    app.world_mut().get_mut::<Frequency>(entity).unwrap().set_changed();
    update(&mut app);
    near_frequencies(&app, 1.0_f32);
}

#[test]
fn buffers_that_do_not_fit_are_errors_until_they_do() {
    let raw = torus();
    let mut app = app();
    let buffer = |bytes: usize, usage| {
        let mut buffer = ShaderBuffer::new(&vec![0; bytes], RenderAssetUsages::default());
        buffer.buffer_description.usage = usage;
        buffer
    };
    let right = 16 * raw.positions.len();
    let usages = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let handle = app
        .world_mut()
        .resource_mut::<Assets<ShaderBuffer>>()
        .add(buffer(right - 16, usages));
    let entity = spawn(&mut app, &raw, DirectionField::Buffer(handle.clone().into()));
    let state = |app: &mut App| {
        wait(app, entity);
        app.world().get::<PatternState>(entity).unwrap().clone()
    };
    let found = state(&mut app);
    let PatternState::Failed(PatternError::BufferSize { found, needed, .. }) = found else {
        panic!("{found:?}");
    };
    assert_eq!((found + 16, needed), (right as u64, right as u64));
    let change = |app: &mut App, buffer| {
        let mut buffers = app.world_mut().resource_mut::<Assets<ShaderBuffer>>();
        *buffers.get_mut(&handle).unwrap() = buffer;
    };
    change(&mut app, buffer(right, BufferUsages::STORAGE | BufferUsages::COPY_DST));
    let found = state(&mut app);
    assert!(
        matches!(found, PatternState::Failed(PatternError::BufferUsage(_))),
        "{found:?}"
    );
    change(&mut app, buffer(right, usages));
    let found = state(&mut app);
    assert!(
        matches!(found, PatternState::Solving | PatternState::Converged),
        "{found:?}"
    );
}
