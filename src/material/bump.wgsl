#define_import_path bevy_field_patterns::bump

// Bump mapping from a height whose derivatives along the screen are known. A pure function.
//
// position_dx, _dy   how the position moves along the screen   [world units/pixel]
// height_slope       derivatives of the height along the screen [world units/pixel]

// The normal of a surface raised by a height (Mikkelsen 2010), from derivatives along the screen.
fn bumped_normal(
    normal: vec3<f32>,
    position_dx: vec3<f32>,
    position_dy: vec3<f32>,
    height_slope: vec2<f32>,
) -> vec3<f32> {
    let r1 = cross(position_dy, normal);
    let r2 = cross(normal, position_dx);
    let area = dot(position_dx, r1);
    let tilt = sign(area) * (height_slope.x * r1 + height_slope.y * r2);
    let bent = abs(area) * normal - tilt;
    return select(normal, normalize(bent), dot(bent, bent) > 0.0);
}
