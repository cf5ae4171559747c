//! Decodes buffer views of `EXT_meshopt_compression`.
//!
//! After the extension's specification: appendix A (bitstream) and appendix B (filters).

use serde::Deserialize;

/// What a view holds, and so how it is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What is done to attributes after decompression.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

/// Decodes `count` elements of `stride` bytes each.
pub(super) fn decode(
    data: &[u8],
    mode: Mode,
    filter: Filter,
    count: usize,
    stride: usize,
) -> Result<Vec<u8>, String> {
    match mode {
        Mode::Attributes => {
            let mut decoded = attributes(data, count, stride)?;
            apply(filter, &mut decoded, stride)?;
            Ok(decoded)
        }
        Mode::Triangles => narrow(&triangles(data, count)?, stride),
        Mode::Indices => narrow(&indices(data, count)?, stride),
    }
}

/// A stream that ends is an error.
struct Stream<'a>(&'a [u8]);

impl<'a> Stream<'a> {
    /// Checks the first byte and cuts off the tail.
    fn new(data: &'a [u8], header: u8, tail: usize) -> Result<(Self, &'a [u8]), String> {
        let (&found, rest) = data.split_first().ok_or("the stream is empty")?;
        if found != header {
            return Err(format!("the stream starts with {found:#04x}, not {header:#04x}"));
        }
        let length = rest.len().checked_sub(tail).ok_or("the stream is too short for its tail")?;
        let (body, tail) = rest.split_at(length);
        Ok((Self(body), tail))
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(length).ok_or("the stream ends too early")?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// An unsigned LEB128 number of 32 bits.
    fn varint(&mut self) -> Result<u32, String> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err("a number has more than 5 bytes".to_owned())
    }

    fn finish(&self) -> Result<(), String> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(format!("{} bytes are left over after the last element", self.0.len()))
        }
    }
}

/// [EXT_meshopt_compression, appendix A, mode 0: attributes]
fn attributes(data: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    const GROUP: usize = 16;
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return Err(format!("a stride of {stride} is not a multiple of 4 up to 256"));
    }
    let (mut stream, tail) = Stream::new(data, 0xa0, stride.max(32))?;
    let mut previous = tail[tail.len() - stride..].to_vec();
    let block = ((8192 / stride) & !(GROUP - 1)).min(256);
    let mut decoded = Vec::new();
    let mut left = count;
    while left > 0 {
        let elements = left.min(block);
        let groups = elements.div_ceil(GROUP);
        let start = decoded.len();
        decoded.resize(start + elements * stride, 0);
        for (byte, previous) in previous.iter_mut().enumerate() {
            let header = stream.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let bits = header[group / 4] >> (group % 4 * 2) & 3;
                let deltas = deltas(&mut stream, bits)?;
                let first = group * GROUP;
                for (element, delta) in (first..elements).zip(deltas) {
                    *previous = previous.wrapping_add(unzigzag(u32::from(delta)) as u8);
                    decoded[start + element * stride + byte] = *previous;
                }
            }
        }
        left -= elements;
    }
    stream.finish()?;
    Ok(decoded)
}

/// The 16 deltas of a group, still in zigzag order.
fn deltas(stream: &mut Stream<'_>, bits: u8) -> Result<[u8; 16], String> {
    let mut deltas = [0; 16];
    let width = match bits {
        0 => return Ok(deltas),
        1 => 2,
        2 => 4,
        _ => {
            deltas.copy_from_slice(stream.take(16)?);
            return Ok(deltas);
        }
    };
    let sentinel = (1 << width) - 1;
    let per_byte = 8 / width;
    let packed = stream.take(16 / per_byte)?;
    for (index, delta) in deltas.iter_mut().enumerate() {
        let shift = 8 - width * (index % per_byte + 1);
        let value = packed[index / per_byte] >> shift & sentinel;
        *delta = if value == sentinel { stream.byte()? } else { value };
    }
    Ok(deltas)
}

/// Signed numbers with the sign in the lowest bit.
fn unzigzag(value: u32) -> u32 {
    if value & 1 == 0 { value >> 1 } else { !(value >> 1) }
}

/// The last 16 of something, the most recent first.
struct Recent<T>([T; 16], usize);

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self([T::default(); 16], 0)
    }

    fn push(&mut self, value: T) {
        self.0[self.1 % 16] = value;
        self.1 += 1;
    }

    fn get(&self, age: u8) -> T {
        self.0[(self.1 + 15 - usize::from(age)) % 16]
    }
}

/// Where the third corner, or each of three, comes from.
struct Corners<'a> {
    stream: Stream<'a>,
    vertices: Recent<u32>,
    next: u32,
    last: u32,
}

impl Corners<'_> {
    fn next(&mut self) -> u32 {
        let vertex = self.next;
        self.next = self.next.wrapping_add(1);
        vertex
    }

    fn explicit(&mut self) -> Result<u32, String> {
        self.last = self.last.wrapping_add(unzigzag(self.stream.varint()?));
        Ok(self.last)
    }

    /// A corner by its code: 0 is a new vertex, 15 an explicit one, others are recent ones.
    fn coded(&mut self, code: u8) -> Result<u32, String> {
        match code {
            0 => Ok(self.next()),
            15 => self.explicit(),
            recent => Ok(self.vertices.get(recent - 1)),
        }
    }
}

/// [EXT_meshopt_compression, appendix A, mode 1: triangles]
fn triangles(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    if !count.is_multiple_of(3) {
        return Err(format!("{count} indices are no whole number of triangles"));
    }
    let (mut stream, table) = Stream::new(data, 0xe1, 16)?;
    let codes = stream.take(count / 3)?;
    let mut corners = Corners { stream, vertices: Recent::new(), next: 0, last: 0 };
    let mut edges = Recent::<[u32; 2]>::new();
    let mut decoded = Vec::with_capacity(count);
    for &code in codes {
        let (high, low) = (code >> 4, code & 15);
        let [a, b, c] = if high < 15 {
            let [a, b] = edges.get(high);
            let c = match low {
                0 => corners.next(),
                1..=12 => corners.vertices.get(low),
                13 | 14 => {
                    let step = if low == 13 { u32::MAX } else { 1 };
                    corners.last = corners.last.wrapping_add(step);
                    corners.last
                }
                _ => corners.explicit()?,
            };
            if !(1..=12).contains(&low) {
                corners.vertices.push(c);
            }
            [a, b, c]
        } else {
            let (pair, first) = match low {
                0..14 => (table[usize::from(low)], 0),
                14 => (corners.stream.byte()?, 0),
                _ => (corners.stream.byte()?, 15),
            };
            if low >= 14 && pair == 0 {
                corners.next = 0;
            }
            let (second, third) = (pair >> 4, pair & 15);
            let triangle = [corners.coded(first)?, corners.coded(second)?, corners.coded(third)?];
            for (code, vertex) in [first, second, third].into_iter().zip(triangle) {
                if code == 0 || code == 15 {
                    corners.vertices.push(vertex);
                }
            }
            let [a, b, _] = triangle;
            edges.push([b, a]);
            triangle
        };
        edges.push([c, b]);
        edges.push([a, c]);
        decoded.extend([a, b, c]);
    }
    corners.stream.finish()?;
    Ok(decoded)
}

/// [EXT_meshopt_compression, appendix A, mode 2: indices]
fn indices(data: &[u8], count: usize) -> Result<Vec<u32>, String> {
    let (mut stream, _) = Stream::new(data, 0xd1, 4)?;
    let mut baselines = [0_u32; 2];
    let mut decoded = Vec::new();
    for _ in 0..count {
        let code = stream.varint()?;
        let baseline = &mut baselines[(code & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag(code >> 1));
        decoded.push(*baseline);
    }
    stream.finish()?;
    Ok(decoded)
}

/// Indices as little-endian numbers of 2 or 4 bytes.
fn narrow(indices: &[u32], stride: usize) -> Result<Vec<u8>, String> {
    match stride {
        4 => Ok(indices.iter().flat_map(|index| index.to_le_bytes()).collect()),
        2 => {
            let narrowed = indices.iter().map(|&index| u16::try_from(index));
            let narrowed = narrowed.collect::<Result<Vec<_>, _>>();
            let narrowed = narrowed.map_err(|_| "an index does not fit in 2 bytes")?;
            Ok(narrowed.iter().flat_map(|index| index.to_le_bytes()).collect())
        }
        _ => Err(format!("indices have a stride of 2 or 4 bytes, not {stride}")),
    }
}

/// [EXT_meshopt_compression, appendix B: filters]
fn apply(filter: Filter, data: &mut [u8], stride: usize) -> Result<(), String> {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => {
            for element in data.as_chunks_mut::<4>().0 {
                let input = element.map(|byte| f32::from(byte as i8));
                let unit = octahedral([input[0], input[1]], input[2]);
                for (output, unit) in element.iter_mut().zip(unit) {
                    *output = (unit * 127.0).round() as i8 as u8;
                }
            }
        }
        (Filter::Octahedral, 8) => {
            for element in data.as_chunks_mut::<8>().0 {
                let input = components(element).map(f32::from);
                let unit = octahedral([input[0], input[1]], input[2]);
                for (output, unit) in element.as_chunks_mut::<2>().0.iter_mut().zip(unit) {
                    *output = ((unit * 32767.0).round() as i16).to_le_bytes();
                }
            }
        }
        (Filter::Quaternion, 8) => {
            for element in data.as_chunks_mut::<8>().0 {
                let input = components(element);
                let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(input[3] | 3);
                let [x, y, z] = [input[0], input[1], input[2]].map(|c| f32::from(c) * scale);
                let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
                let largest = (input[3] & 3) as usize;
                let outputs = element.as_chunks_mut::<2>().0;
                for (step, value) in [w, x, y, z].into_iter().enumerate() {
                    outputs[(largest + step) % 4] =
                        ((value * 32767.0).round() as i16).to_le_bytes();
                }
            }
        }
        (Filter::Exponential, _) => {
            for element in data.as_chunks_mut::<4>().0 {
                let packed = i32::from_le_bytes(*element);
                let (exponent, mantissa) = (packed >> 24, packed << 8 >> 8);
                *element = ((mantissa as f32) * (exponent as f32).exp2()).to_le_bytes();
            }
        }
        (filter, stride) => return Err(format!("filter {filter:?} has no stride of {stride}")),
    }
    Ok(())
}

fn components(element: &[u8; 8]) -> [i16; 4] {
    let [a, b, c, d, e, f, g, h] = *element;
    [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes)
}

/// The unit vector of octahedral coordinates, all in units of `one`.
fn octahedral([x, y]: [f32; 2], one: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

#[cfg(test)]
mod tests {
    use meshopt_rs::index::IndexEncodingVersion;
    use meshopt_rs::index::buffer::{encode_index_buffer, encode_index_buffer_bound};
    use meshopt_rs::index::sequence::{encode_index_sequence, encode_index_sequence_bound};
    use meshopt_rs::vertex::VertexEncodingVersion;
    use meshopt_rs::vertex::buffer::{encode_vertex_buffer, encode_vertex_buffer_bound};

    use super::*;

    /// Noise without a generator, the same every time.
    fn noise(seed: u32) -> u32 {
        let mixed = (seed ^ 0x9e37_79b9).wrapping_mul(0x85eb_ca6b);
        (mixed ^ (mixed >> 13)).wrapping_mul(0xc2b2_ae35) >> 8
    }

    /// Bytes that are alike, nearly alike and unlike their neighbours, to meet every width.
    fn vertices<const STRIDE: usize>(count: u32) -> Vec<[u8; STRIDE]> {
        let value = |i: u32, b: u32| match b % 4 {
            0 => 7,
            1 => (i / 3) as u8,
            2 => (i as u8).wrapping_add((noise(i) % 6) as u8 * u8::from(i.is_multiple_of(9))),
            _ => noise(i * 64 + b) as u8,
        };
        (0..count).map(|i| std::array::from_fn(|b| value(i, b as u32))).collect()
    }

    fn attributes_round_trip<const STRIDE: usize>(count: u32) {
        let vertices = vertices::<STRIDE>(count);
        let mut data = vec![0; encode_vertex_buffer_bound(vertices.len(), STRIDE)];
        let length =
            encode_vertex_buffer(&mut data, &vertices, VertexEncodingVersion::default()).unwrap();
        data.truncate(length);
        let decoded =
            |data: &[u8]| decode(data, Mode::Attributes, Filter::None, count as usize, STRIDE);
        assert_eq!(decoded(&data).unwrap(), vertices.concat());
        // Negative controls: one bit, one byte less.
        let mut broken = data.clone();
        broken[length - 1] ^= 1;
        assert_ne!(decoded(&broken), Ok(vertices.concat()));
        for cut in 0..length.min(200) {
            assert!(decoded(&data[..cut]).is_err(), "cut at {cut}");
        }
    }

    #[test]
    fn attributes_decode_to_what_was_encoded() {
        attributes_round_trip::<4>(1);
        attributes_round_trip::<12>(700);
        attributes_round_trip::<16>(16);
        attributes_round_trip::<64>(333);
        attributes_round_trip::<256>(40);
    }

    /// A grid whose triangles share edges, with strangers in between.
    fn grid(side: u32) -> Vec<u32> {
        let mut indices = Vec::new();
        for y in 0..side {
            for x in 0..side {
                let [a, b] = [y * (side + 1) + x, (y + 1) * (side + 1) + x];
                indices.extend([a, b, a + 1, a + 1, b, b + 1]);
                if (x * y) % 7 == 3 {
                    indices.extend([noise(x) % 60_000, noise(y) % 60_000, noise(x + y) % 60_000]);
                }
            }
        }
        indices
    }

    #[test]
    fn triangles_decode_to_what_was_encoded_up_to_the_first_corner() {
        let indices = grid(40);
        let mut data = vec![0; encode_index_buffer_bound(indices.len(), 65_536)];
        let length = encode_index_buffer(&mut data, &indices, IndexEncodingVersion::V1).unwrap();
        data.truncate(length);
        let decoded = triangles(&data, indices.len()).unwrap();
        // The encoder may rotate a triangle.
        let rotated = |indices: &[u32]| -> Vec<[u32; 3]> {
            let triangles = indices.as_chunks::<3>().0.iter().copied();
            triangles
                .map(|[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap())
                .collect()
        };
        assert_eq!(rotated(&decoded), rotated(&indices));
        assert_ne!(rotated(&decoded), rotated(&grid(41))[..decoded.len() / 3]);
        for cut in 0..length {
            assert!(triangles(&data[..cut], indices.len()).is_err(), "cut at {cut}");
        }
        let narrowed = decode(&data, Mode::Triangles, Filter::None, indices.len(), 2);
        assert_eq!(narrowed.unwrap().len(), indices.len() * 2);
    }

    #[test]
    fn indices_decode_to_what_was_encoded() {
        let sequence: Vec<u32> = (0..500).map(|i| if i % 2 == 0 { i } else { noise(i) }).collect();
        let mut data = vec![0; encode_index_sequence_bound(sequence.len(), 1 << 24)];
        let length = encode_index_sequence(&mut data, &sequence, IndexEncodingVersion::V1);
        data.truncate(length);
        assert_eq!(indices(&data, sequence.len()).unwrap(), sequence);
        assert!(indices(&data, sequence.len() - 1).is_err());
        let narrowed = decode(&data, Mode::Indices, Filter::None, sequence.len(), 2);
        assert_eq!(narrowed, Err("an index does not fit in 2 bytes".to_owned()));
    }

    #[test]
    fn the_example_of_the_specification_decodes() {
        let bytes = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut stream = Stream(&bytes);
        let deltas = deltas(&mut stream, 2).unwrap().map(|d| unzigzag(u32::from(d)) as i8);
        assert_eq!(deltas, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert!(stream.finish().is_ok());
    }

    #[test]
    fn filters_undo_their_encoding() {
        // 10 bits: one is 511; the vector (0, 0, -1) folds onto a corner.
        let mut octahedral: Vec<u8> =
            [0_i16, 0, 511, 9, 511, 511, 511, 9].iter().flat_map(|c| c.to_le_bytes()).collect();
        apply(Filter::Octahedral, &mut octahedral, 8).unwrap();
        let [up, down] = [0, 8].map(|at| components(octahedral[at..at + 8].try_into().unwrap()));
        assert_eq!((up, down), ([0, 0, 32767, 9], [0, 0, -32767, 9]));

        let mut exponential = (((-3_i32) << 24) | 40).to_le_bytes();
        apply(Filter::Exponential, &mut exponential, 4).unwrap();
        assert_eq!(f32::from_le_bytes(exponential), 5.0);

        // The largest component is y; 11 bits: one is 1023, which ends in the bits of 3, so that
        // the index of the largest replaces them.
        let mut quaternion: Vec<u8> =
            [0_i16, 0, 1023, 1021].iter().flat_map(|c| c.to_le_bytes()).collect();
        apply(Filter::Quaternion, &mut quaternion, 8).unwrap();
        let half = (std::f32::consts::FRAC_1_SQRT_2 * 32767.0).round() as i16;
        assert_eq!(components(quaternion[..].try_into().unwrap()), [half, half, 0, 0]);
        assert!(apply(Filter::Quaternion, &mut quaternion, 12).is_err());
    }
}
