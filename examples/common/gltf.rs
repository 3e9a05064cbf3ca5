//! glTF files: fields they carry, and the types of their scenes.

use bevy::{
    animation::{AnimatedBy, AnimationPlayer, AnimationTargetId},
    camera::{
        primitives::Aabb,
        visibility::{DynamicSkinnedMeshBounds, NoFrustumCulling},
    },
    gltf::{
        GltfExtras, GltfMaterialExtras, GltfMaterialName, GltfMeshExtras, GltfMeshName, GltfPlugin, GltfSceneExtras,
        GltfSceneName,
    },
    mesh::{
        MeshVertexAttribute,
        morph::{MeshMorphWeights, MorphWeights},
        skinning::SkinnedMesh,
    },
    prelude::*,
    render::render_resource::VertexFormat,
};

/// The attribute `_FIELD` of a file: three floats per vertex, a direction of any length.
pub const FIELD_ATTRIBUTE: MeshVertexAttribute =
    MeshVertexAttribute::new("Field", 0x0F1E_1D00, VertexFormat::Float32x3);

/// The attribute `_TENSOR_DIAGONAL` of a file: xx, yy, zz of a symmetric tensor per vertex.
pub const TENSOR_DIAGONAL_ATTRIBUTE: MeshVertexAttribute =
    MeshVertexAttribute::new("TensorDiagonal", 0x0F1E_1D06, VertexFormat::Float32x3);

/// The attribute `_TENSOR_OFFDIAGONAL` of a file: xy, yz, xz of that tensor.
pub const TENSOR_OFFDIAGONAL_ATTRIBUTE: MeshVertexAttribute =
    MeshVertexAttribute::new("TensorOffdiagonal", 0x0F1E_1D07, VertexFormat::Float32x3);

/// Bevy's reader of glTF files, which also reads the attributes above. It wants names without their first underscore.
pub fn gltf_plugin() -> GltfPlugin {
    GltfPlugin::default()
        .add_custom_vertex_attribute("FIELD", FIELD_ATTRIBUTE)
        .add_custom_vertex_attribute("TENSOR_DIAGONAL", TENSOR_DIAGONAL_ATTRIBUTE)
        .add_custom_vertex_attribute("TENSOR_OFFDIAGONAL", TENSOR_OFFDIAGONAL_ATTRIBUTE)
}

/// Bevy copies a glTF scene into the world by reflection and panics at a type that is not registered, which, without its
/// feature `reflect_auto_register`, nobody else does.
pub fn register_scene_types(app: &mut App) {
    app.register_type::<Name>()
        .register_type::<Children>()
        .register_type::<ChildOf>()
        .register_type::<Transform>()
        .register_type::<GlobalTransform>()
        .register_type::<TransformTreeChanged>()
        .register_type::<Visibility>()
        .register_type::<InheritedVisibility>()
        .register_type::<ViewVisibility>()
        .register_type::<Aabb>()
        .register_type::<NoFrustumCulling>()
        .register_type::<DynamicSkinnedMeshBounds>()
        .register_type::<Mesh3d>()
        .register_type::<MeshMaterial3d<StandardMaterial>>()
        .register_type::<SkinnedMesh>()
        .register_type::<MorphWeights>()
        .register_type::<MeshMorphWeights>()
        .register_type::<AnimationPlayer>()
        .register_type::<AnimationTargetId>()
        .register_type::<AnimatedBy>()
        .register_type::<GltfExtras>()
        .register_type::<GltfSceneExtras>()
        .register_type::<GltfMeshExtras>()
        .register_type::<GltfMaterialExtras>()
        .register_type::<GltfSceneName>()
        .register_type::<GltfMeshName>()
        .register_type::<GltfMaterialName>()
        .register_type::<DirectionalLight>()
        .register_type::<PointLight>()
        .register_type::<SpotLight>()
        .register_type::<Camera>()
        .register_type::<Camera3d>()
        .register_type::<Projection>();
}
