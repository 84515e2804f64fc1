//! What a zlib stream holds: RFC 1950 around RFC 1951.

/// Base lengths and extra bits of the length symbols 257 to 285 (RFC 1951, 3.2.5).
const LENGTHS: [(u16, u8); 29] = [
    (3, 0),
    (4, 0),
    (5, 0),
    (6, 0),
    (7, 0),
    (8, 0),
    (9, 0),
    (10, 0),
    (11, 1),
    (13, 1),
    (15, 1),
    (17, 1),
    (19, 2),
    (23, 2),
    (27, 2),
    (31, 2),
    (35, 3),
    (43, 3),
    (51, 3),
    (59, 3),
    (67, 4),
    (83, 4),
    (99, 4),
    (115, 4),
    (131, 5),
    (163, 5),
    (195, 5),
    (227, 5),
    (258, 0),
];

/// Base distances and extra bits of the distance symbols (the same place).
const DISTANCES: [(u16, u8); 30] = [
    (1, 0),
    (2, 0),
    (3, 0),
    (4, 0),
    (5, 1),
    (7, 1),
    (9, 2),
    (13, 2),
    (17, 3),
    (25, 3),
    (33, 4),
    (49, 4),
    (65, 5),
    (97, 5),
    (129, 6),
    (193, 6),
    (257, 7),
    (385, 7),
    (513, 8),
    (769, 8),
    (1025, 9),
    (1537, 9),
    (2049, 10),
    (3073, 10),
    (4097, 11),
    (6145, 11),
    (8193, 12),
    (12289, 12),
    (16385, 13),
    (24577, 13),
];

/// In which order the lengths of the code for code lengths come (RFC 1951, 3.2.7).
const ORDER: [usize; 19] = [
    16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15,
];

/// The bytes that the zlib stream `stream` holds; none where it is no such stream, is cut short or
/// fails its checksum.
pub(super) fn inflate(stream: &[u8]) -> Option<Vec<u8>> {
    let (&method, &flags) = (stream.first()?, stream.get(1)?);
    let header = u16::from_be_bytes([method, flags]);
    // deflate, a header of the right check, no preset dictionary
    if method & 15 != 8 || !header.is_multiple_of(31) || flags & 32 != 0 {
        return None;
    }
    let mut bits = Bits {
        bytes: &stream[2..],
        at: 0,
    };
    let mut out = Vec::new();
    loop {
        let last = bits.take(1)? == 1;
        match bits.take(2)? {
            0 => bits.stored(&mut out)?,
            1 => {
                let (literals, distances) = fixed()?;
                bits.block(&mut out, &literals, &distances)?;
            }
            2 => {
                let (literals, distances) = bits.codes()?;
                bits.block(&mut out, &literals, &distances)?;
            }
            _ => return None,
        }
        if last {
            break;
        }
    }
    let sum = bits.rest().get(..4)?;
    (sum == adler32(&out).to_be_bytes()).then_some(out)
}

/// Adler-32 (RFC 1950, section 9).
fn adler32(bytes: &[u8]) -> u32 {
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65521;
        (a, (b + a) % 65521)
    });
    b << 16 | a
}

/// A stream of bits, the lowest of each byte first.
struct Bits<'a> {
    bytes: &'a [u8],
    /// Number of bits taken.
    at: usize,
}

impl<'a> Bits<'a> {
    /// The next `count` bits as a number, at most 16.
    fn take(&mut self, count: u8) -> Option<u32> {
        let mut value = 0;
        for nth in 0..count {
            let byte = *self.bytes.get(self.at / 8)?;
            value |= u32::from(byte >> (self.at % 8) & 1) << nth;
            self.at += 1;
        }
        Some(value)
    }

    /// What follows, from the next whole byte.
    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at.div_ceil(8)..).unwrap_or_default()
    }

    /// A block as it is (3.2.4).
    fn stored(&mut self, out: &mut Vec<u8>) -> Option<()> {
        let rest = self.rest();
        let word = |at: usize| Some(u16::from_le_bytes([*rest.get(at)?, *rest.get(at + 1)?]));
        let (length, inverse) = (word(0)?, word(2)?);
        if length != !inverse {
            return None;
        }
        let length = usize::from(length);
        out.extend(rest.get(4..4 + length)?);
        self.at = 8 * (self.at.div_ceil(8) + 4 + length);
        Some(())
    }

    /// A block in codes (3.2.3).
    fn block(&mut self, out: &mut Vec<u8>, literals: &Code, distances: &Code) -> Option<()> {
        loop {
            let symbol = literals.read(self)?;
            let length = match symbol {
                0..256 => {
                    out.push(symbol as u8);
                    continue;
                }
                256 => return Some(()),
                _ => self.number(*LENGTHS.get(usize::from(symbol) - 257)?)?,
            };
            let symbol = distances.read(self)?;
            let distance = self.number(*DISTANCES.get(usize::from(symbol))?)?;
            let start = out.len().checked_sub(distance)?;
            // what is copied may have been written by this very copy
            for from in start..start + length {
                out.push(out[from]);
            }
        }
    }

    fn number(&mut self, (base, extra): (u16, u8)) -> Option<usize> {
        Some(usize::from(base) + self.take(extra)? as usize)
    }

    /// The codes that a block begins with (3.2.7).
    fn codes(&mut self) -> Option<(Code, Code)> {
        let counts = [self.take(5)? + 257, self.take(5)? + 1, self.take(4)? + 4];
        let [literals, distances, lengths] = counts.map(|count| count as usize);
        let mut of_lengths = [0; 19];
        for &place in &ORDER[..lengths] {
            of_lengths[place] = self.take(3)? as u8;
        }
        let of_lengths = Code::new(&of_lengths)?;
        let mut all: Vec<u8> = Vec::new();
        while all.len() < literals + distances {
            let (length, times) = match of_lengths.read(self)? {
                16 => (*all.last()?, 3 + self.take(2)?),
                17 => (0, 3 + self.take(3)?),
                18 => (0, 11 + self.take(7)?),
                length => (length as u8, 1),
            };
            all.extend(std::iter::repeat_n(length, times as usize));
        }
        let (literals, distances) = all
            .split_at_checked(literals)
            .filter(|(_, d)| d.len() == distances)?;
        Some((Code::new(literals)?, Code::new(distances)?))
    }
}

/// The codes of blocks that bring none (3.2.6).
fn fixed() -> Option<(Code, Code)> {
    let mut lengths = [8; 288];
    lengths[144..256].fill(9);
    lengths[256..280].fill(7);
    Some((Code::new(&lengths)?, Code::new(&[5; 30])?))
}

/// A canonical Huffman code (3.2.2): how many codes of each length, and the symbols in their order.
struct Code {
    counts: [u16; 16],
    symbols: Vec<u16>,
}

impl Code {
    /// The code of the `lengths` of its symbols; none where there are more codes than bits tell
    /// apart.
    fn new(lengths: &[u8]) -> Option<Self> {
        let mut counts = [0; 16];
        for &length in lengths {
            counts[usize::from(length)] += 1;
        }
        counts[0] = 0;
        let mut left = 1i32;
        for count in &counts[1..] {
            left = 2 * left - i32::from(*count);
            if left < 0 {
                return None;
            }
        }
        let mut symbols: Vec<u16> = (0..lengths.len() as u16)
            .filter(|&symbol| lengths[usize::from(symbol)] > 0)
            .collect();
        symbols.sort_by_key(|&symbol| lengths[usize::from(symbol)]);
        Some(Self { counts, symbols })
    }

    /// The next symbol of `bits`: codes of one length are consecutive numbers.
    fn read(&self, bits: &mut Bits) -> Option<u16> {
        let (mut code, mut first, mut index) = (0, 0, 0);
        for count in &self.counts[1..] {
            code |= bits.take(1)?;
            let count = u32::from(*count);
            if code < first + count {
                return self.symbols.get((index + code - first) as usize).copied();
            }
            index += count;
            first = (first + count) << 1;
            code <<= 1;
        }
        None
    }
}
