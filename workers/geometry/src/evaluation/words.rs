//! Values as words.

use glam::{DVec2, DVec3};

/// A value that a message carries as words.
pub trait Words: Sized {
    /// Appends the words of the value.
    fn write(&self, words: &mut Vec<u64>);

    /// Reads a value. Missing words are 0.
    fn read(from: &mut Reader<'_>) -> Self;

    /// Reads a value from its words.
    fn of(words: &[u64]) -> Self {
        Self::read(&mut Reader(words))
    }
}

/// The words that are not read yet.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a>(pub &'a [u64]);

impl Reader<'_> {
    /// Reads a word.
    pub fn word(&mut self) -> u64 {
        let Some((&word, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        word
    }

    /// Returns `true` if all words are read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// A point as the words of its coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At<P>(pub P);

impl<P: crate::point::Point> Words for At<P> {
    fn write(&self, words: &mut Vec<u64>) {
        words.extend((0..P::DIM).map(|i| self.0.coord(i).to_bits()));
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let mut point = P::splat(0.0);
        for i in 0..P::DIM {
            point.set_coord(i, f64::from_bits(from.word()));
        }
        At(point)
    }
}

macro_rules! words {
    ($($kind:ty: |$value:ident| $write:expr, |$word:ident| $read:expr;)+) => {
        $(impl Words for $kind {
            fn write(&self, words: &mut Vec<u64>) {
                let $value = *self;
                words.push($write);
            }

            fn read(from: &mut Reader<'_>) -> Self {
                let $word = from.word();
                $read
            }
        })+
    };
}

words! {
    u64: |x| x, |word| word;
    u32: |x| u64::from(x), |word| word as u32;
    u8: |x| u64::from(x), |word| word as u8;
    bool: |x| u64::from(x), |word| word != 0;
    f64: |x| x.to_bits(), |word| f64::from_bits(word);
}

impl Words for () {
    fn write(&self, _words: &mut Vec<u64>) {}

    fn read(_from: &mut Reader<'_>) -> Self {}
}

macro_rules! same {
    ($($kind:ty),+) => {
        $(impl Words for $kind {
            fn write(&self, words: &mut Vec<u64>) {
                At(*self).write(words);
            }

            fn read(from: &mut Reader<'_>) -> Self {
                At::read(from).0
            }
        })+
    };
}

same!(DVec2, DVec3);

impl<A: Words, B: Words> Words for (A, B) {
    fn write(&self, words: &mut Vec<u64>) {
        self.0.write(words);
        self.1.write(words);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        (A::read(from), B::read(from))
    }
}

impl<A: Words, B: Words, C: Words> Words for (A, B, C) {
    fn write(&self, words: &mut Vec<u64>) {
        self.0.write(words);
        self.1.write(words);
        self.2.write(words);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        (A::read(from), B::read(from), C::read(from))
    }
}

impl<T: Words, const N: usize> Words for [T; N] {
    fn write(&self, words: &mut Vec<u64>) {
        for value in self {
            value.write(words);
        }
    }

    fn read(from: &mut Reader<'_>) -> Self {
        std::array::from_fn(|_| T::read(from))
    }
}

impl<T: Words> Words for Option<T> {
    fn write(&self, words: &mut Vec<u64>) {
        words.push(u64::from(self.is_some()));
        if let Some(value) = self {
            value.write(words);
        }
    }

    fn read(from: &mut Reader<'_>) -> Self {
        (from.word() != 0).then(|| T::read(from))
    }
}

/// A list takes the rest of the words.
impl<T: Words> Words for Vec<T> {
    fn write(&self, words: &mut Vec<u64>) {
        for value in self {
            value.write(words);
        }
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let mut all = Vec::new();
        while !from.is_empty() {
            all.push(T::read(from));
        }
        all
    }
}
