//! Words that emitted identifiers stay clear of, and the Greek alphabet.

/// Rust 2024: strict, weak and reserved keywords.
const RUST: &str = "\
    abstract as async await become box break const continue crate do dyn else enum \
    extern false final fn for gen if impl in let loop macro macro_rules match mod move \
    mut override priv pub raw ref return safe self Self static struct super trait true \
    try type typeof union unsafe unsized use virtual where while yield";

/// Keywords of C99 and C++.
const C: &str = "\
    alignas alignof and and_eq asm auto bitand bitor bool case catch char class compl \
    concept consteval constexpr constinit const_cast co_await co_return co_yield \
    decltype default delete double dynamic_cast explicit export float friend goto inline \
    int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private \
    protected public register reinterpret_cast requires restrict short signed sizeof \
    static_assert static_cast switch template this thread_local throw typedef typeid \
    typename unsigned using void volatile wchar_t xor xor_eq";

/// Macros of C's headers and compilers.
const MACROS: &str = "\
    DOMAIN EDOM EILSEQ ERANGE FP_INFINITE FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO HUGE_VAL HUGE_VALF \
    INFINITY MATH_ERREXCEPT MATH_ERRNO MAXFLOAT M_1_PI M_2_PI M_E M_LN10 M_LN2 \
    M_LOG10E M_LOG2E M_PI M_PI_2 M_PI_4 M_SQRT1_2 M_SQRT2 NAN NULL OVERFLOW PLOSS SING \
    TLOSS UNDERFLOW errno i386 linux math_errhandling unix";

/// Functions of C's headers, and of generated C, that a variable would hide.
const FUNCTIONS: &str = "\
    i complex imaginary sign_of step_of near far sin cos tan asin acos atan atan2 sinh \
    cosh tanh exp log sqrt pow fabs floor ceil gamma lgamma tgamma erf j0 j1 jn y0 y1 yn \
    signgam abs div index time real";

/// Greek letters with their names.
const GREEK: &str = "\
    αalpha βbeta γgamma δdelta εepsilon ζzeta ηeta θtheta ιiota κkappa λlambda μmu νnu \
    ξxi οomicron πpi ρrho σsigma ςsigma τtau υupsilon φphi χchi ψpsi ωomega Γgamma \
    Δdelta Θtheta Λlambda Ξxi Πpi Σsigma Φphi Ψpsi Ωomega";

/// Whether no identifier may be this word, in any language that is emitted.
pub(super) fn is_reserved(word: &str) -> bool {
    word == "_" || [RUST, C, MACROS].iter().any(|list| is_in(list, word))
}

/// Whether a variable of this name would hide a function.
pub(super) fn hides_a_function(word: &str) -> bool {
    is_in(FUNCTIONS, word)
}

/// The name of a Greek letter.
pub(super) fn greek(letter: char) -> Option<&'static str> {
    let mut entries = GREEK.split_whitespace();
    entries.find_map(|entry| entry.strip_prefix(letter))
}

fn is_in(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|known| known == word)
}
