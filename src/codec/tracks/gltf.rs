//! glTF 2.0: a node an animal under one root, all of one mesh, with a linear animation of place
//! and rotation. y is up and z is south, as glTF wants it: east, up, south = x, z, −y.
//!
//! One node an animal suits a few thousand animals; for more, engines read the binary form.

use base64::Engine as _;
use serde_json::Value;
use serde_json::json;

use super::TrackFile;
use super::moving_features::unwrapped;
use crate::compute::herds::animation::Pose;

const FLOAT: u32 = 5126;
const U16: u32 = 5123;

/// Outline of a body of half length 1 and half width 1: (along, half width); the nose is narrow.
const PROFILE: [(f64, f64); 6] = [(-1.0, 0.25), (-0.8, 0.75), (-0.1, 1.0), (0.5, 0.8), (0.8, 0.4), (1.0, 0.12)];
const SIDES: usize = 8;

impl TrackFile<'_> {
    /// The scene with its animation, everything in one JSON document. Places are from the origin,
    /// times from the first pose.
    pub fn to_gltf(&self) -> Value {
        let mut buffer = Buffer::default();
        // 1. The body that all share.
        let (vertices, triangles) = body();
        let position = buffer.vectors(&vertices, true);
        let indices = buffer.indices(&triangles);
        // 2. The times that all share.
        let start = self.tracks.times_s.first().copied().unwrap_or(0.0);
        let times = buffer.scalars(self.tracks.times_s.iter().map(|t| (*t - start) as f32));
        // 3. A node, two samplers and two channels an animal.
        let (mut nodes, mut samplers, mut channels) = (Vec::new(), Vec::new(), Vec::new());
        for animal in 0..self.tracks.animals {
            let (places, turns) = self.path(animal);
            let (a, b) = self.bodies.get(animal).copied().unwrap_or((1.0, 1.0));
            nodes.push(json!({
                "name": format!("animal {animal}"),
                "mesh": 0,
                "translation": places.first(),
                "rotation": turns.first(),
                "scale": [b, b, a],
            }));
            for (path, output) in
                [("translation", buffer.vectors(&places, false)), ("rotation", buffer.vectors(&turns, false))]
            {
                channels.push(json!({"sampler": samplers.len(), "target": {"node": animal + 1, "path": path}}));
                samplers.push(json!({"input": times, "output": output, "interpolation": "LINEAR"}));
            }
        }
        // 4. The root, which the others hang on.
        let children: Vec<usize> = (1..=self.tracks.animals).collect();
        nodes.insert(0, json!({"name": "herd", "children": children}));
        json!({
            "asset": {
                "version": "2.0",
                "generator": "Biotope",
                "extras": {"simulated": true, "origin_m": [self.origin.x, self.origin.y], "start_s": start},
            },
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": nodes,
            "meshes": [{"name": "body", "primitives": [
                {"attributes": {"POSITION": position}, "indices": indices, "material": 0},
            ]}],
            "materials": [{"name": "coat", "pbrMetallicRoughness": {
                "baseColorFactor": [0.22, 0.14, 0.08, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9,
            }}],
            "animations": [{"name": "walk", "samplers": samplers, "channels": channels}],
            "accessors": buffer.accessors,
            "bufferViews": buffer.views,
            "buffers": [{"byteLength": buffer.bytes.len(), "uri": data_address(&buffer.bytes)}],
        })
    }

    /// Places and rotations of an animal, a row a step.
    fn path(&self, animal: usize) -> (Vec<[f32; 3]>, Vec<[f32; 4]>) {
        let poses = || (0..self.tracks.times_s.len()).map(|step| self.tracks.pose(step, animal));
        let place = |p: Pose| {
            let from = p.place - self.origin;
            [from.x as f32, p.z as f32, -from.y as f32]
        };
        // The body looks along +z, which is south: a quarter turn more brings it to east. Without
        // jumps the angle's half has none either, so neighbours lie on the shorter arc.
        let turn = |heading: f64| {
            let half = (heading + std::f64::consts::FRAC_PI_2) / 2.0;
            [0.0, libm::sin(half) as f32, 0.0, libm::cos(half) as f32]
        };
        (poses().map(place).collect(), unwrapped(poses().map(|p| p.heading)).map(turn).collect())
    }
}

/// Corners and triangles of the body, standing on the ground.
fn body() -> (Vec<[f32; 3]>, Vec<u16>) {
    let ring = |(along, half): (f64, f64)| {
        (0..SIDES).map(move |k| {
            let angle = std::f64::consts::TAU * k as f64 / SIDES as f64;
            [(half * libm::cos(angle)) as f32, (1.0 + half * libm::sin(angle)) as f32, along as f32]
        })
    };
    let vertices: Vec<[f32; 3]> = PROFILE.into_iter().flat_map(ring).collect();
    let mut triangles = Vec::new();
    let at = |ring: usize, k: usize| (ring * SIDES + k % SIDES) as u16;
    for r in 0..PROFILE.len() - 1 {
        for k in 0..SIDES {
            triangles.extend([at(r, k), at(r, k + 1), at(r + 1, k)]);
            triangles.extend([at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)]);
        }
    }
    let last = PROFILE.len() - 1;
    for k in 1..SIDES - 1 {
        triangles.extend([at(0, 0), at(0, k + 1), at(0, k)]);
        triangles.extend([at(last, 0), at(last, k), at(last, k + 1)]);
    }
    (vertices, triangles)
}

fn data_address(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

/// The bytes of all accessors; a view for each.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn push(&mut self, bytes: &[u8], mut accessor: Value) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        accessor["bufferView"] = self.views.len().into();
        self.views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors<const N: usize>(&mut self, rows: &[[f32; N]], with_bounds: bool) -> usize {
        let mut accessor = json!({"componentType": FLOAT, "count": rows.len(), "type": format!("VEC{N}")});
        if with_bounds {
            let bound = |pick: fn(f32, f32) -> f32, from: f32| -> Vec<f32> {
                (0..N).map(|c| rows.iter().map(|row| row[c]).fold(from, pick)).collect()
            };
            accessor["min"] = json!(bound(f32::min, f32::INFINITY));
            accessor["max"] = json!(bound(f32::max, f32::NEG_INFINITY));
        }
        let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.push(&bytes, accessor)
    }

    fn scalars(&mut self, values: impl Iterator<Item = f32>) -> usize {
        let values: Vec<f32> = values.collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let ends = (values.first(), values.last());
        let accessor =
            json!({"componentType": FLOAT, "count": values.len(), "type": "SCALAR", "min": [ends.0], "max": [ends.1]});
        self.push(&bytes, accessor)
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.push(&bytes, json!({"componentType": U16, "count": indices.len(), "type": "SCALAR"}))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::map::Georeference;
    use crate::codec::tracks::tests::file;
    use crate::codec::tracks::tests::tracks;

    fn scene() -> Value {
        let (tracks, place) = (tracks(), Georeference::local("test"));
        file(&tracks, &place).to_gltf()
    }

    /// The numbers of an accessor.
    fn numbers(scene: &Value, accessor: &Value) -> Vec<f32> {
        let accessor = &scene["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &scene["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let uri = scene["buffers"][0]["uri"].as_str().unwrap().split_once(',').unwrap().1;
        let bytes = base64::engine::general_purpose::STANDARD.decode(uri).unwrap();
        assert_eq!(bytes.len() as u64, scene["buffers"][0]["byteLength"].as_u64().unwrap());
        let (at, n) = (view["byteOffset"].as_u64().unwrap() as usize, view["byteLength"].as_u64().unwrap() as usize);
        assert!(at.is_multiple_of(4) && at + n <= bytes.len());
        bytes[at..at + n].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    fn output(scene: &Value, channel: usize) -> Vec<f32> {
        let channel = &scene["animations"][0]["channels"][channel];
        let sampler = &scene["animations"][0]["samplers"][channel["sampler"].as_u64().unwrap() as usize];
        assert_eq!(numbers(scene, &sampler["input"]), [0.0, 0.5, 1.25]);
        numbers(scene, &sampler["output"])
    }

    #[test]
    fn places_are_east_up_south_from_the_origin() {
        let scene = scene();
        assert_eq!(output(&scene, 0), [9.0, 15.0, -18.0, 10.0, 16.0, -18.0, 12.0, 18.0, -18.0]);
        assert_eq!(scene["nodes"][1]["translation"], json!([9.0, 15.0, -18.0]));
        assert_eq!(
            (scene["nodes"].as_array().unwrap().len(), scene["animations"][0]["channels"].as_array().unwrap().len()),
            (3, 4)
        );
    }

    #[test]
    fn a_body_looks_where_it_heads_and_turns_the_shorter_way() {
        let turns = output(&scene(), 3);
        for (quaternion, heading) in turns.chunks_exact(4).zip([1.5_f64, 3.1, -3.1]) {
            let (y, w) = (f64::from(quaternion[1]), f64::from(quaternion[3]));
            // +z turned by the quaternion about y.
            let (east, south) = (2.0 * y * w, w * w - y * y);
            assert!((east - heading.cos()).abs() < 1e-6 && (south + heading.sin()).abs() < 1e-6);
        }
        let dot: f32 = turns[4..8].iter().zip(&turns[8..12]).map(|(a, b)| a * b).sum();
        assert!(dot > 0.99);
    }

    #[test]
    fn every_triangle_of_the_body_faces_outwards() {
        let (vertices, triangles) = body();
        let at = |i: u16| vertices[usize::from(i)].map(f64::from);
        let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        for corner in triangles.chunks_exact(3) {
            let (a, b, c) = (at(corner[0]), at(corner[1]), at(corner[2]));
            let (u, v) = (minus(b, a), minus(c, a));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0 - [0.0, 1.0, 0.0][k]);
            let outwards: f64 = normal.iter().zip(middle).map(|(n, m)| n * m).sum();
            assert!(outwards > 0.0, "{corner:?}");
        }
    }
}
