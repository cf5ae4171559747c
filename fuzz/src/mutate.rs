//! One input from another.

/// A pseudo-random number generator. [Steele et al. 2014, SplitMix64]
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn number(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number from 0 to one below `bound`.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.number() % bound.max(1) as u64) as usize
    }
}

/// The dictionary for every format; the numbers come first.
const WORDS: [&[u8]; 28] = [
    b"0",
    b"-1",
    b"1",
    b"255",
    b"65536",
    b"4294967295",
    b"18446744073709551615",
    b"1e38",
    b"-1e39",
    b"1e999",
    b"NaN",
    b"inf",
    b"null",
    b"true",
    b"[]",
    b"{}",
    b"\"\"",
    b",",
    b"\n",
    b"\r",
    b"#",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\0",
    b"\xfc",
    b"../",
    b"[[[[[[[[",
    b"{\"a\":",
];

/// How many of [`WORDS`] are numbers.
const NUMBERS: usize = 16;

/// `whole` with one to five changes: of bytes and bits, stretches that go, come twice or repeat often, numbers and words.
#[must_use]
pub fn mutated(whole: &[u8], words: &[&[u8]], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        let span = at.min(bytes.len())..(at + 1 + random.below(24)).min(bytes.len());
        match random.below(10) {
            0 | 1 if at < bytes.len() => bytes[at] = random.number() as u8,
            2 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            3 => drop(bytes.drain(span)),
            4 => {
                let copy = bytes[span].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            5 if random.below(8) == 0 => bytes.truncate(at),
            6 => {
                // The next number is replaced.
                let digit = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
                if let Some(first) = bytes.iter().skip(at).position(digit).map(|step| at + step) {
                    let length = bytes[first..].iter().take_while(|byte| digit(byte)).count();
                    let word = WORDS[random.below(NUMBERS)];
                    bytes.splice(first..first + length, word.iter().copied());
                }
            }
            7 if random.below(8) == 0 => {
                // For limits of nesting and of counts.
                let copy = bytes[span.clone()].repeat(1 << random.below(12));
                bytes.splice(span.end..span.end, copy);
            }
            _ => {
                let all = WORDS.len() + words.len();
                let word = random.below(all);
                let word = words.get(word).copied().unwrap_or_else(|| WORDS[word - words.len()]);
                let end = at + if random.below(2) == 0 { 0 } else { span.len() };
                bytes.splice(at.min(bytes.len())..end.min(bytes.len()), word.iter().copied());
            }
        }
    }
    bytes
}
