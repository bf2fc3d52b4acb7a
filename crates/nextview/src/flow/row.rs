use std::iter::Copied;
use std::slice::Iter;

/// A set of column numbers in the smaller of two forms.
///
/// Both are words, and their number distinguishes the forms: enough for a bit per column mean bits, fewer
/// mean a sorted list.
#[derive(Clone, Copy)]
pub(super) enum Row<'a> {
    List(&'a [u32]),
    Bits(&'a [u32]),
}

impl<'a> Row<'a> {
    /// Creates the row from these words; `n_words` words would hold a bit for every column.
    #[inline]
    pub fn new(words: &'a [u32], n_words: usize) -> Self {
        if words.len() == n_words { Self::Bits(words) } else { Self::List(words) }
    }

    /// The words that hold the row, equal for rows of equal content.
    pub fn words(self) -> &'a [u32] {
        let (Self::List(words) | Self::Bits(words)) = self;
        words
    }

    /// The columns in increasing order.
    #[inline]
    pub fn columns(self) -> Columns<'a> {
        match self {
            Self::List(list) => Columns::List(list.iter().copied()),
            Self::Bits(bits) => Columns::Bits { rest: bits.iter().copied(), word: 0, end: 0 },
        }
    }

    /// Number of columns.
    pub fn len(self) -> usize {
        match self {
            Self::List(list) => list.len(),
            Self::Bits(bits) => bits.iter().map(|word| word.count_ones() as usize).sum(),
        }
    }

    /// Whether another row over the same columns has every column of this one.
    pub fn is_subset_of(self, other: Self) -> bool {
        match (self, other) {
            (Self::List(a), Self::List(b)) => is_sublist(a, b),
            (Self::List(a), Self::Bits(b)) => a.iter().all(|&column| has_bit(b, column)),
            (Self::Bits(a), Self::Bits(b)) => a.iter().zip(b).all(|(a, b)| a & !b == 0),
            // Bits represent more columns than any list holds.
            (Self::Bits(_), Self::List(_)) => false,
        }
    }

    /// The columns modulo 64, a bit for each: a row that holds all columns of another holds all its bits too.
    pub fn signature(self) -> u64 {
        match self {
            Self::List(list) => list.iter().fold(0, |all, column| all | 1 << (column % 64)),
            Self::Bits(bits) => {
                bits.iter().enumerate().fold(0, |all, (i, &word)| all | u64::from(word) << (i % 2 * 32))
            }
        }
    }
}

/// The columns of a [`Row`] in increasing order.
#[derive(Clone)]
pub(super) enum Columns<'a> {
    List(Copied<Iter<'a, u32>>),
    /// `word` holds the unreported bits of the columns `end - 32..end`.
    Bits {
        rest: Copied<Iter<'a, u32>>,
        word: u32,
        end: u32,
    },
}

impl Iterator for Columns<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        match self {
            Self::List(list) => list.next(),
            Self::Bits { rest, word, end } => {
                while *word == 0 {
                    *word = rest.next()?;
                    *end += 32;
                }
                let column = *end - 32 + word.trailing_zeros();
                *word &= *word - 1;
                Some(column)
            }
        }
    }

    /// Checks the form once for all columns.
    #[inline]
    fn fold<B, F: FnMut(B, u32) -> B>(self, init: B, mut f: F) -> B {
        match self {
            Self::List(list) => list.fold(init, f),
            bits => {
                let mut folded = init;
                for column in bits {
                    folded = f(folded, column);
                }
                folded
            }
        }
    }
}

/// Number of words that hold a bit for every column.
pub(super) fn n_words(n_columns: usize) -> usize {
    n_columns.div_ceil(32)
}

/// Sets the bit of a column.
#[inline]
pub(super) fn set_bit(bits: &mut [u32], column: u32) {
    bits[column as usize / 32] |= 1 << (column % 32);
}

#[inline]
fn has_bit(bits: &[u32], column: u32) -> bool {
    bits[column as usize / 32] >> (column % 32) & 1 == 1
}

fn is_sublist(inner: &[u32], outer: &[u32]) -> bool {
    let mut rest = outer.iter();
    inner.len() <= outer.len()
        && inner.iter().all(|column| rest.find(|other| *other >= column) == Some(column))
}
