//! Random objects (scratch version).
#![allow(missing_docs, clippy::all)]
use crate::mesh::TriangleMesh;
use glam::{DMat3, DQuat, DVec2, DVec3};
use nextview::geometry::random::Random;
use std::f64::consts::TAU;

#[derive(Default)]
struct Soup {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Soup {
    fn grid(&mut self, nu: usize, nv: usize, at: impl Fn(f64, f64) -> DVec3) {
        let base = self.vertices.len() as u32;
        for i in 0..=nu {
            for j in 0..=nv {
                self.vertices.push(at(i as f64 / nu as f64, j as f64 / nv as f64));
            }
        }
        let row = nv as u32 + 1;
        for i in 0..nu as u32 {
            for j in 0..nv as u32 {
                let a = base + i * row + j;
                self.triangles.push([a, a + row, a + 1]);
                self.triangles.push([a + 1, a + row, a + row + 1]);
            }
        }
    }
    fn append(&mut self, other: &Soup, map: impl Fn(DVec3) -> DVec3) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(other.vertices.iter().map(|&v| map(v)));
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }
}

fn spow(x: f64, e: f64) -> f64 {
    x.signum() * x.abs().powf(e)
}

fn smooth(r: &mut Random, n: usize, lo: f64, hi: f64) -> impl Fn(f64) -> f64 + use<> {
    let k: Vec<f64> = (0..n).map(|_| r.range(lo, hi)).collect();
    move |t: f64| {
        let x = t.clamp(0.0, 1.0) * (k.len() - 1) as f64;
        let i = (x as usize).min(k.len() - 2);
        let s = x - i as f64;
        let s = s * s * (3.0 - 2.0 * s);
        k[i] * (1.0 - s) + k[i + 1] * s
    }
}

fn superellipsoid(r: &mut Random) -> Soup {
    let e = [0.05, 0.1, 0.2, 0.5, 1.0, 1.0];
    let (e1, e2) = (e[r.index(6)], e[r.index(6)]);
    let size = DVec3::new(r.range(0.25, 1.0), r.range(0.25, 1.0), r.range(0.2, 1.0));
    let thin = if r.unit() < 0.25 { DVec3::new(1.0, 1.0, r.range(0.06, 0.2)) } else { DVec3::ONE };
    let (taper, bend) = (
        r.range(-0.5, 0.5) * (r.unit() < 0.4) as u8 as f64,
        r.range(-0.6, 0.6) * (r.unit() < 0.3) as u8 as f64,
    );
    let mut s = Soup::default();
    s.grid(48, 32, |u, v| {
        let (a, b) = (u * TAU, (v - 0.5) * TAU / 2.0);
        let p = DVec3::new(
            spow(b.cos(), e1) * spow(a.cos(), e2),
            spow(b.cos(), e1) * spow(a.sin(), e2),
            spow(b.sin(), e1),
        );
        let t = 1.0 + taper * p.z;
        let p = DVec3::new(p.x * t, p.y * t, p.z);
        let p = p * size * thin;
        DVec3::new(p.x + bend * p.z * p.z, p.y, p.z)
    });
    s
}

fn lathe(r: &mut Random) -> Soup {
    let n_knots = 2 + r.index(4);
    let radius = smooth(r, n_knots, 0.15, 0.8);
    let (height, wall) = (r.range(0.4, 2.0), r.range(0.02, 0.08));
    let hollow = r.unit() < 0.5;
    let sides = if r.unit() < 0.25 { 3 + r.index(6) } else { 48 };
    let squash = if r.unit() < 0.3 { r.range(0.4, 1.0) } else { 1.0 };
    let floor = r.range(0.02, 0.3);
    let mut profile: Vec<DVec2> = vec![DVec2::new(0.0, 0.0)];
    for i in 0..=24 {
        let t = i as f64 / 24.0;
        profile.push(DVec2::new(radius(t), t * height));
    }
    if hollow {
        for i in (0..=24).rev() {
            let t = i as f64 / 24.0;
            if t >= floor {
                profile.push(DVec2::new((radius(t) - wall).max(0.01), t * height));
            }
        }
        profile.push(DVec2::new(0.0, floor * height));
    } else {
        profile.push(DVec2::new(0.0, height));
    }
    let n = profile.len() - 1;
    let mut s = Soup::default();
    s.grid(sides, n, |u, v| {
        let p = profile[(v * n as f64).round() as usize];
        let a = u * TAU;
        DVec3::new(p.x * a.cos(), squash * p.x * a.sin(), p.y - height * 0.5)
    });
    s
}

fn tube(r: &mut Random) -> Soup {
    let arc = r.unit() < 0.5;
    let extent = if r.unit() < 0.3 { TAU } else { r.range(1.5, 5.5) };
    let p: Vec<DVec3> = (0..4).map(|_| r.in_cube()).collect();
    let curve = |t: f64| {
        if arc {
            let a = t * extent;
            DVec3::new(0.7 * a.cos(), 0.7 * a.sin(), 0.0)
        } else {
            let s = 1.0 - t;
            p[0] * s * s * s + p[1] * 3.0 * s * s * t + p[2] * 3.0 * s * t * t + p[3] * t * t * t
        }
    };
    let (ra, rb) = (r.range(0.04, 0.25), r.range(0.04, 0.25));
    let mut s = Soup::default();
    s.grid(48, 24, |u, v| {
        let d = (curve((u + 0.01).min(1.0)) - curve((u - 0.01).max(0.0))).normalize_or(DVec3::X);
        let side = d.any_orthonormal_vector();
        let side = if arc { DVec3::Z } else { side };
        let up = d.cross(side);
        let a = v * TAU;
        // closed ends
        let shrink = if !arc || extent < TAU { (u.min(1.0 - u) * 12.0).min(1.0).sqrt() } else { 1.0 };
        curve(u) + (side * ra * a.cos() + up * rb * a.sin()) * shrink
    });
    s
}

fn extrusion(r: &mut Random) -> Soup {
    let n = 3 + r.index(10);
    let deep = r.range(0.0, 0.6);
    let random = r.unit() < 0.5;
    let smooth_shape = r.unit() < 0.4;
    let rad: Vec<f64> = (0..n)
        .map(|i| {
            if random {
                r.range(0.4, 1.0)
            } else if i % 2 == 0 {
                1.0
            } else {
                1.0 - deep
            }
        })
        .collect();
    let hole = if r.unit() < 0.5 { r.range(0.15, 0.7) } else { 0.0 };
    let h = if r.unit() < 0.4 { r.range(0.05, 0.2) } else { r.range(0.2, 1.2) };
    let outline = |u: f64| {
        let x = u.rem_euclid(1.0) * n as f64;
        let (i, f) = (x as usize % n, x.fract());
        let at = |i: usize| DVec2::from_angle(i as f64 / n as f64 * TAU) * rad[i % n];
        if smooth_shape {
            DVec2::from_angle(u * TAU) * {
                let f = f * f * (3.0 - 2.0 * f);
                rad[i] * (1.0 - f) + rad[(i + 1) % n] * f
            }
        } else {
            at(i).lerp(at(i + 1), f)
        }
    };
    let path = [(hole, -1.0), (1.0, -1.0), (1.0, 1.0), (hole, 1.0), (hole, -1.0)];
    let mut s = Soup::default();
    s.grid(n * 12, 16, |u, v| {
        let x = v * 4.0;
        let i = (x as usize).min(3);
        let f = x - i as f64;
        let k = path[i].0 * (1.0 - f) + path[i + 1].0 * f;
        let z = path[i].1 * (1.0 - f) + path[i + 1].1 * f;
        (outline(u) * k).extend(z * h * 0.5)
    });
    s
}

fn blob(r: &mut Random) -> Soup {
    let waves: Vec<(DVec3, f64, f64)> =
        (0..6).map(|_| (r.in_cube() * 4.0, r.range(0.0, TAU), r.range(0.03, 0.2))).collect();
    let size = DVec3::new(r.range(0.4, 1.0), r.range(0.4, 1.0), r.range(0.4, 1.0));
    let mut s = Soup::default();
    s.grid(64, 32, |u, v| {
        let (a, b) = (u * TAU, (v - 0.5) * TAU / 2.0);
        let p = DVec3::new(b.cos() * a.cos(), b.cos() * a.sin(), b.sin());
        let k: f64 = 1.0 + waves.iter().map(|(w, ph, am)| am * (w.dot(p) + ph).sin()).sum::<f64>();
        p * k * size
    });
    s
}

fn open_box(r: &mut Random) -> Soup {
    let h = DVec3::new(r.range(0.4, 1.0), r.range(0.4, 1.0), r.range(0.2, 1.0));
    let w = r.range(0.02, 0.08);
    let mut s = Soup::default();
    let mut slab = |c: DVec3, e: DVec3| {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                s.grid(8, 8, |u, v| {
                    let mut p = DVec3::ZERO;
                    p[axis] = sign;
                    p[(axis + 1) % 3] = 2.0 * u - 1.0;
                    p[(axis + 2) % 3] = 2.0 * v - 1.0;
                    c + p * e
                });
            }
        }
    };
    slab(DVec3::new(0.0, 0.0, -h.z), DVec3::new(h.x, h.y, w));
    for sign in [-1.0, 1.0] {
        slab(DVec3::new(sign * h.x, 0.0, 0.0), DVec3::new(w, h.y, h.z));
        slab(DVec3::new(0.0, sign * h.y, 0.0), DVec3::new(h.x, w, h.z));
    }
    if r.unit() < 0.3 {
        slab(DVec3::ZERO, DVec3::new(w, h.y, h.z));
    }
    s
}

fn part(r: &mut Random) -> Soup {
    match r.index(10) {
        0..=3 => superellipsoid(r),
        4..=5 => lathe(r),
        6 => tube(r),
        7 => extrusion(r),
        8 => blob(r),
        _ => {
            if r.unit() < 0.5 {
                open_box(r)
            } else {
                extrusion(r)
            }
        }
    }
}

fn rotation(r: &mut Random) -> DMat3 {
    let q = loop {
        let v = [r.range(-1.0, 1.0), r.range(-1.0, 1.0), r.range(-1.0, 1.0), r.range(-1.0, 1.0)];
        let q = DQuat::from_array(v);
        if (0.01..1.0).contains(&q.length_squared()) {
            break q.normalize();
        }
    };
    DMat3::from_quat(q)
}

fn upright(r: &mut Random) -> DMat3 {
    let turns = [DMat3::IDENTITY, DMat3::from_rotation_x(TAU / 4.0), DMat3::from_rotation_y(TAU / 4.0)];
    turns[r.index(3)]
}

/// One of endlessly many.
pub fn random_object(seed: u64) -> TriangleMesh {
    let mut r = Random::new(seed, 9);
    let mut s = Soup::default();
    let n = 1 + r.index(6);
    let symmetric = r.unit() < 0.4;
    for i in 0..n {
        let p = part(&mut r);
        let m = if r.unit() < 0.6 { upright(&mut r) } else { rotation(&mut r) };
        if i == 0 {
            s.append(&p, |v| m * v);
            continue;
        }
        let scale = r.range(0.2, 0.9);
        let at = s.vertices[r.index(s.vertices.len())];
        s.append(&p, |v| at + m * v * scale);
        if symmetric {
            s.append(&p, |v| {
                let w = at + m * v * scale;
                DVec3::new(-w.x, w.y, w.z)
            });
        }
    }
    let stretch = DVec3::new(r.range(0.6, 1.0), r.range(0.6, 1.0), r.range(0.5, 1.0));
    let m = if r.unit() < 0.5 { DMat3::from_rotation_z(r.range(0.0, TAU)) } else { rotation(&mut r) };
    let v = s.vertices.iter().map(|&v| m * (v * stretch)).collect();
    let mesh = TriangleMesh::new(v, s.triangles).unwrap();
    let k = 0.2 / mesh.bounds().longest_side();
    mesh.scaled(k).unwrap()
}
