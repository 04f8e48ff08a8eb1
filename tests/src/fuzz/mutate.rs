//! Damage to a text by its tokens and lines.

use super::corpus::Corpus;
use super::kind::Kind;
use super::token::{Class, Token, tokens};
use super::{nest, scraps, table};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::borrow::Cow;
use std::ops::Range;

/// An input may have this many bytes, so that a million of them can be run; the limits on
/// the size of each kind of file have tests of their own.
pub const LONGEST: usize = 256 << 10;
/// A text has at most this many damages, most have few: a text with many is refused at the
/// first of them.
const MOST: u32 = 8;
/// How many texts are nothing but tokens in a row, and tokens of one at most.
const SOUP: f64 = 0.03;
const TOKENS: u32 = 60;
/// Tokens of a piece that is moved, deleted or doubled.
const PIECE: usize = 24;
/// Lines of a piece that is.
const LINES: usize = 6;

/// A text under damage.
pub struct Mutation<'c, 'r> {
    corpus: &'c Corpus,
    kind: Kind,
    rng: &'r mut ChaCha8Rng,
    tokens: Vec<Token<'c>>,
}

/// A text of the corpus, damaged.
pub fn mutated(corpus: &Corpus, kind: Kind, rng: &mut ChaCha8Rng, text: &str) -> String {
    let text = if kind.is_table() && rng.random_bool(0.6) {
        table::changed(rng, text)
    } else {
        text.to_string()
    };
    let mut mutation = Mutation {
        corpus,
        kind,
        rng,
        tokens: owned(tokens(&text)),
    };
    if mutation.rng.random_bool(SOUP) {
        mutation.soup();
    }
    // One damage as likely as two, two as three or four, and so on.
    let most = 1 << mutation.rng.random_range(0..=MOST.ilog2());
    for _ in 0..mutation.rng.random_range(1..=most) {
        mutation.damage();
    }
    mutation.text()
}

fn owned<'c>(tokens: Vec<Token<'_>>) -> Vec<Token<'c>> {
    let owned = |token: Token<'_>| Token {
        class: token.class,
        text: Cow::Owned(token.text.into_owned()),
    };
    tokens.into_iter().map(owned).collect()
}

impl<'c> Mutation<'c, '_> {
    /// The text as it is now, cut off where it is too long.
    fn text(self) -> String {
        let mut text: String = self.tokens.iter().map(|t| t.text.as_ref()).collect();
        let mut end = text.len().min(LONGEST);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        text.truncate(end);
        text
    }

    fn damage(&mut self) {
        if self.tokens.is_empty() {
            self.insert();
            return;
        }
        match self.rng.random_range(0..100_u32) {
            0..30 => self.tweak_number(),
            30..42 => self.exchange(),
            42..54 => self.rename(),
            54..60 => self.substitute(),
            60..64 => self.insert(),
            64..67 => self.delete(),
            67..70 => self.double(),
            70..72 => self.swap(),
            72..78 => self.delete_lines(),
            78..82 => self.double_lines(),
            82..86 => self.swap_lines(),
            86..92 => self.graft_lines(),
            92..97 => self.nest(),
            _ => self.repeat(),
        }
    }

    /// Puts any tokens in the place of the text.
    fn soup(&mut self) {
        self.tokens.clear();
        for _ in 0..self.rng.random_range(0..TOKENS) {
            self.insert();
            let space = Token {
                class: Class::Space,
                text: Cow::Borrowed(" "),
            };
            self.tokens.push(space);
        }
    }

    fn tweak_number(&mut self) {
        let Some(at) = self.any(Class::Number) else {
            return self.substitute();
        };
        let new = if self.rng.random_bool(0.5) {
            scraps::number_near(self.rng, &self.tokens[at].text)
        } else {
            scraps::number(self.rng)
        };
        self.tokens[at].text = Cow::Owned(new);
    }

    /// Puts another word that is used alike in the place of one: what is damaged is what the
    /// text says, not its grammar.
    fn exchange(&mut self) {
        let family = |token: &Token<'_>| {
            let mut families = scraps::FAMILIES.into_iter();
            families.find(|family| family.iter().any(|word| *word == token.text))
        };
        let start = self.rng.random_range(0..self.tokens.len());
        let mut places = (start..self.tokens.len()).chain(0..start);
        let found = places.find_map(|at| Some((at, family(&self.tokens[at])?)));
        match found {
            Some((at, family)) => {
                self.tokens[at].text = Cow::Borrowed(*scraps::pick(self.rng, family));
            }
            None => self.tweak_number(),
        }
    }

    /// Puts another token of the same class in the place of one.
    fn substitute(&mut self) {
        let class = [Class::Word, Class::Sign][self.rng.random_range(0..2_usize)];
        if let Some(at) = self.any(class) {
            let new = self.token(class);
            self.tokens[at] = new;
        }
    }

    /// Gives a name another spelling wherever it stands: what is damaged is not the grammar.
    fn rename(&mut self) {
        let Some(at) = self.any(Class::Word) else {
            return;
        };
        let old = self.tokens[at].text.clone();
        let new = self.token(Class::Word).text;
        for token in &mut self.tokens {
            if token.text == old {
                token.text.clone_from(&new);
            }
        }
    }

    fn insert(&mut self) {
        let class = [Class::Word, Class::Sign, Class::Number][self.rng.random_range(0..3_usize)];
        let at = self.rng.random_range(0..=self.tokens.len());
        let new = self.token(class);
        self.tokens.insert(at, new);
    }

    fn delete(&mut self) {
        let piece = self.piece();
        self.tokens.drain(piece);
    }

    fn double(&mut self) {
        let piece = self.piece();
        let copy = self.tokens[piece].to_vec();
        let at = self.rng.random_range(0..=self.tokens.len());
        self.tokens.splice(at..at, copy);
    }

    fn swap(&mut self) {
        let piece = self.piece();
        let moved: Vec<Token<'c>> = self.tokens.drain(piece).collect();
        let at = self.rng.random_range(0..=self.tokens.len());
        self.tokens.splice(at..at, moved);
    }

    fn delete_lines(&mut self) {
        let lines = self.lines();
        self.tokens.drain(lines);
    }

    fn double_lines(&mut self) {
        let lines = self.lines();
        let copy = self.tokens[lines].to_vec();
        let at = self.lines().start;
        self.tokens.splice(at..at, copy);
    }

    fn swap_lines(&mut self) {
        let lines = self.lines();
        let moved: Vec<Token<'c>> = self.tokens.drain(lines).collect();
        let at = self.lines().start;
        self.tokens.splice(at..at, moved);
    }

    /// Lines of another file of the kind.
    fn graft_lines(&mut self) {
        let texts = &self.corpus.of(self.kind);
        let other = tokens(&texts[self.rng.random_range(0..texts.len())].text);
        let lines = lines(self.rng, &other);
        let at = self.lines().start;
        self.tokens.splice(at..at, other[lines].to_vec());
    }

    fn nest(&mut self) {
        let piece = self.piece();
        let text: String = self.tokens[piece.clone()]
            .iter()
            .map(|token| token.text.as_ref())
            .collect();
        let nested = Token {
            class: Class::Sign,
            text: Cow::Owned(nest::nested(self.rng, &text)),
        };
        self.tokens.splice(piece, [nested]);
    }

    /// The same piece very often.
    fn repeat(&mut self) {
        let piece = if self.rng.random_bool(0.5) {
            self.piece()
        } else {
            self.lines()
        };
        let text: String = self.tokens[piece.clone()]
            .iter()
            .map(|token| token.text.as_ref())
            .collect();
        let most = LONGEST / text.len().max(1);
        let times = (1_usize << self.rng.random_range(2..17_u32)).min(most);
        let repeated = Token {
            class: Class::Sign,
            text: Cow::Owned(text.repeat(times)),
        };
        self.tokens.splice(piece, [repeated]);
    }

    /// A new token: one of this text, of a text of its kind, or one that is known to hurt.
    fn token(&mut self, class: Class) -> Token<'c> {
        let own = self.any(class).map(|at| self.tokens[at].clone());
        match (self.rng.random_range(0..4_u32), own) {
            (0 | 1, Some(own)) => own,
            (2, _) if class == Class::Word => Token {
                class,
                text: Cow::Borrowed(scraps::pick(self.rng, self.corpus.words(self.kind)).as_str()),
            },
            _ if class == Class::Number => Token {
                class,
                text: Cow::Owned(scraps::number(self.rng)),
            },
            _ => Token {
                class,
                text: Cow::Owned(scraps::word(self.rng)),
            },
        }
    }

    /// Where any token of a class stands.
    fn any(&mut self, class: Class) -> Option<usize> {
        let start = self.rng.random_range(0..self.tokens.len().max(1));
        let places = (start..self.tokens.len()).chain(0..start);
        let mut of_class = places.filter(|&at| self.tokens[at].class == class);
        of_class.next()
    }

    fn piece(&mut self) -> Range<usize> {
        let start = self.rng.random_range(0..self.tokens.len().max(1));
        let length = self.rng.random_range(1..=PIECE);
        start..(start + length).min(self.tokens.len())
    }

    fn lines(&mut self) -> Range<usize> {
        lines(self.rng, &self.tokens)
    }
}

/// Some whole lines.
fn lines(rng: &mut ChaCha8Rng, tokens: &[Token<'_>]) -> Range<usize> {
    let behind = |(at, token): (usize, &Token<'_>)| token.is_line_end().then_some(at + 1);
    let mut starts = vec![0];
    starts.extend(tokens.iter().enumerate().filter_map(behind));
    let first = rng.random_range(0..starts.len());
    let last = first + rng.random_range(1..=LINES);
    starts[first]..starts.get(last).copied().unwrap_or(tokens.len())
}
