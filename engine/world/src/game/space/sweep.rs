//! When a moving ball or box first touches a triangle (Ericson, Real-Time Collision Detection, 2005, 5.1.5 and 5.5).

use glam::Vec3;

/// The first touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Share of the motion, 0..1.
    pub fraction: f32,
    /// Where the triangle is touched.
    pub point: Vec3,
    /// Unit normal, towards the moving shape.
    pub normal: Vec3,
}

/// The point of a triangle that is nearest to another one: by the Voronoi regions of its corners, edges and face.
pub fn closest_point(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * ratio(d1, d1 - d3);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * ratio(d2, d2 - d6);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ratio(d4 - d3, (d4 - d3) + (d5 - d6));
    }
    // Straight down to the plane: barycentric coordinates would lose digits on large triangles.
    let normal = ab.cross(ac);
    p - normal * ratio(normal.dot(ap), normal.dot(normal))
}

/// Whether a point of a triangle's plane lies in it, or so near that rounding decides.
fn is_inside(p: Vec3, corners: [Vec3; 3], face: Vec3) -> bool {
    let tolerance = 1e-5 * (1.0 + p.abs().max_element());
    (0..3).all(|i| {
        let edge = corners[(i + 1) % 3] - corners[i];
        face.dot(edge.cross(p - corners[i])) >= -tolerance * edge.length()
    })
}

fn ratio(part: f32, whole: f32) -> f32 {
    if whole == 0.0 { 0.0 } else { part / whole }
}

/// The first touch of a ball with centre c that moves by v: its centre enters the triangle, widened by the radius. That
/// is the face pushed out to the ball's side, a cylinder around each edge, and a sphere around each corner.
pub fn cast_sphere(c: Vec3, radius: f32, v: Vec3, corners: [Vec3; 3]) -> Option<Touch> {
    let nearest = closest_point(c, corners);
    let away = c - nearest;
    let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let side = if face.dot(c - corners[0]) < 0.0 { -face } else { face };
    if away.length_squared() <= radius * radius {
        let normal = away.try_normalize().unwrap_or(side);
        return (v.dot(normal) < 0.0).then_some(Touch { fraction: 0.0, point: nearest, normal });
    }
    let (height, speed) = (side.dot(c - corners[0]), side.dot(v));
    let mut first: Option<f32> = None;
    if side != Vec3::ZERO && speed < 0.0 {
        // Rounding may have put it a little nearer than its radius, while it is no overlap yet.
        let t = ((radius - height) / speed).max(0.0);
        let foot = c + v * t - side * (height + speed * t);
        if t <= 1.0 && is_inside(foot, corners, face) {
            return Some(Touch { fraction: t, point: foot, normal: side });
        }
    }
    for edge in 0..3 {
        let (p, q) = (corners[edge], corners[(edge + 1) % 3]);
        for t in [enters_cylinder(c, v, radius, p, q), enters_sphere(c, v, radius, p)].into_iter().flatten() {
            first = Some(first.map_or(t, |first| first.min(t)));
        }
    }
    let fraction = first?;
    let center = c + v * fraction;
    let point = closest_point(center, corners);
    let normal = (center - point).try_normalize()?;
    (v.dot(normal) < 0.0).then_some(Touch { fraction, point, normal })
}

/// When a point enters a sphere.
fn enters_sphere(c: Vec3, v: Vec3, radius: f32, p: Vec3) -> Option<f32> {
    let m = c - p;
    first_root(v.dot(v), m.dot(v), m.dot(m) - radius * radius)
}

/// When a point enters the side of a cylinder between its ends.
fn enters_cylinder(c: Vec3, v: Vec3, radius: f32, p: Vec3, q: Vec3) -> Option<f32> {
    let (e, m) = (q - p, c - p);
    let ee = e.dot(e);
    if ee == 0.0 {
        return None;
    }
    // Without their parts along the edge.
    let (m_across, v_across) = (m - e * (m.dot(e) / ee), v - e * (v.dot(e) / ee));
    let t = first_root(v_across.dot(v_across), m_across.dot(v_across), m_across.dot(m_across) - radius * radius)?;
    (0.0..=ee).contains(&(m + v * t).dot(e)).then_some(t)
}

/// The smaller root of a·t² + 2·b·t + c in 0..1; 0 if it is inside from the start and goes further in.
fn first_root(a: f32, b: f32, c: f32) -> Option<f32> {
    let discriminant = b * b - a * c;
    if a <= 0.0 || b >= 0.0 || discriminant < 0.0 {
        return None;
    }
    if c <= 0.0 {
        return Some(0.0);
    }
    // c/(−b + √…) is the smaller root without a difference of like numbers.
    let t = c / (-b + discriminant.sqrt());
    (0.0..=1.0).contains(&t).then_some(t)
}

/// The first touch of a box around the origin, in its own axes, that moves by v: separating axes over time, the three
/// of the box, the triangle's normal, and the products of their edges.
pub fn cast_box(half: Vec3, v: Vec3, corners: [Vec3; 3]) -> Option<Touch> {
    let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
    let mut axes = vec![Vec3::X, Vec3::Y, Vec3::Z, edges[0].cross(edges[1])];
    axes.extend(edges.iter().flat_map(|edge| [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis.cross(*edge))));
    let (mut enter, mut leave) = (f32::NEG_INFINITY, f32::INFINITY);
    let mut entered = Vec3::ZERO;
    // The axis along which the box is least deep in at the start.
    let (mut least, mut out) = (f32::INFINITY, Vec3::ZERO);
    for axis in axes {
        let Some(axis) = axis.try_normalize() else { continue };
        let reach = half.dot(axis.abs());
        let spots = corners.map(|corner| corner.dot(axis));
        let low = spots.into_iter().fold(f32::INFINITY, f32::min) - reach;
        let high = spots.into_iter().fold(f32::NEG_INFINITY, f32::max) + reach;
        let depth = (-low).min(high);
        if depth < least {
            (least, out) = (depth, if -low < high { -axis } else { axis });
        }
        let speed = v.dot(axis);
        if speed == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = if speed > 0.0 { (low / speed, high / speed) } else { (high / speed, low / speed) };
        if a > enter {
            (enter, entered) = (a, -axis * speed.signum());
        }
        leave = leave.min(b);
    }
    let is_in = least > 0.0;
    if is_in {
        let touch = Touch { fraction: 0.0, point: closest_point(Vec3::ZERO, corners), normal: out };
        return (v.dot(out) < 0.0).then_some(touch);
    }
    if enter > leave || !(0.0..=1.0).contains(&enter) {
        return None;
    }
    Some(Touch { fraction: enter, point: closest_point(v * enter, corners), normal: entered })
}
