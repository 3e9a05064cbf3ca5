#define_import_path bevy_field_patterns::tensor

// Eigenvalues and eigenvectors of symmetric tensors; the twin of `tensor.rs`.
//
// d    xx, yy, zz
// o    xy, yz, xz

const ROUNDS: u32 = 6u;
const VANISHING: f32 = 1e-12;

struct Eigen {
    // In descending order.
    values: vec3<f32>,
    // Unit columns.
    vectors: mat3x3<f32>,
}

// cos, sin and tan of the rotation that makes the entry pq vanish.
fn rotation(pp: f32, qq: f32, pq: f32) -> vec3<f32> {
    if abs(pq) <= VANISHING {
        return vec3(1.0, 0.0, 0.0);
    }
    let theta = (qq - pp) / (2.0 * pq);
    let t = select(1.0, -1.0, theta < 0.0) / (abs(theta) + sqrt(theta * theta + 1.0));
    let c = inverseSqrt(t * t + 1.0);
    return vec3(c, t * c, t);
}

fn eigen(diagonal: vec3<f32>, off_diagonal: vec3<f32>) -> Eigen {
    let a = max(abs(diagonal), abs(off_diagonal));
    let scale = max(a.x, max(a.y, a.z));
    var x = vec3(1.0, 0.0, 0.0);
    var y = vec3(0.0, 1.0, 0.0);
    var z = vec3(0.0, 0.0, 1.0);
    if !(scale > 0.0 && scale < 3e38) {
        return Eigen(diagonal, mat3x3(x, y, z));
    }
    var d = diagonal / scale;
    var o = off_diagonal / scale;
    for (var round = 0u; round < ROUNDS; round++) {
        var r = rotation(d.x, d.y, o.x);
        d += vec3(-r.z * o.x, r.z * o.x, 0.0);
        o = vec3(0.0, r.y * o.z + r.x * o.y, r.x * o.z - r.y * o.y);
        var kept = x;
        x = r.x * x - r.y * y;
        y = r.y * kept + r.x * y;

        r = rotation(d.y, d.z, o.y);
        d += vec3(0.0, -r.z * o.y, r.z * o.y);
        o = vec3(r.x * o.x - r.y * o.z, 0.0, r.y * o.x + r.x * o.z);
        kept = y;
        y = r.x * y - r.y * z;
        z = r.y * kept + r.x * z;

        r = rotation(d.x, d.z, o.z);
        d += vec3(-r.z * o.z, 0.0, r.z * o.z);
        o = vec3(r.x * o.x - r.y * o.y, r.y * o.x + r.x * o.y, 0.0);
        kept = x;
        x = r.x * x - r.y * z;
        z = r.y * kept + r.x * z;
    }
    d *= scale;
    if d.x < d.y {
        d = d.yxz;
        let kept = x;
        x = y;
        y = kept;
    }
    if d.y < d.z {
        d = d.xzy;
        let kept = y;
        y = z;
        z = kept;
    }
    if d.x < d.y {
        d = d.yxz;
        let kept = x;
        x = y;
        y = kept;
    }
    return Eigen(d, mat3x3(x, y, z));
}

// A T A^T / |det A|^(2/3) as (diagonal, off-diagonal) columns: the tensor carried along by the linear map A.
fn carried_tensor(diagonal: vec3<f32>, off_diagonal: vec3<f32>, a: mat3x3<f32>) -> mat2x3<f32> {
    let d = diagonal;
    let o = off_diagonal;
    let t = mat3x3(d.x, o.x, o.z, o.x, d.y, o.y, o.z, o.y, d.z);
    let m = a * t * transpose(a) * pow(abs(determinant(a)), -2.0 / 3.0);
    return mat2x3(m[0].x, m[1].y, m[2].z, m[0].y, m[1].z, m[0].z);
}
