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

/// Macros without arguments and without a capital letter that C's standard headers and
/// compilers define, C99 to C23; keywords of the list above are left out. Macros that take
/// arguments (`isnan`, `assert`, `floor` of `<tgmath.h>`) are not here: they are macros in
/// front of a bracket alone, where no member or variable ever stands.
const C_MACROS: &str = "\
    complex errno false far i386 imaginary linux math_errhandling near noreturn sa_handler sa_sigaction si_addr si_addr_lsb si_arch \
    si_band si_call_addr si_fd si_int si_lower si_overrun si_pid si_pkey si_ptr si_status \
    si_stime si_syscall si_timerid si_uid si_upper si_utime si_value \
    sigev_notify_attributes sigev_notify_function stderr stdin stdout true \
    unix";

/// The headers of C99 to C23, without their ending.
const C_HEADERS: &str = "\
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal \
    stdalign stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib \
    stdnoreturn string tgmath threads time uchar wchar wctype";

/// Functions of C's headers, and of generated C, that a variable would hide.
const FUNCTIONS: &str = "\
    i sign_of step_of min_of max_of sin cos tan asin acos atan atan2 sinh \
    cosh tanh exp log sqrt pow fabs floor ceil gamma lgamma tgamma erf j0 j1 jn y0 y1 yn \
    signgam abs div index time real";

/// Greek letters with their names.
const GREEK: &str = "\
    αalpha βbeta γgamma δdelta εepsilon ζzeta ηeta θtheta ιiota κkappa λlambda μmu νnu \
    ξxi οomicron πpi ρrho σsigma ςsigma τtau υupsilon φphi χchi ψpsi ωomega Γgamma \
    Δdelta Θtheta Λlambda Ξxi Πpi Σsigma Φphi Ψpsi Ωomega";

/// Whether no identifier may be this word, in any language that is emitted.
pub(super) fn is_reserved(word: &str) -> bool {
    word == "_" || [RUST, C].iter().any(|list| is_in(list, word))
}

/// Whether a compiler of C may replace this word by something else, whichever standard
/// headers are included: every other macro holds a capital letter or begins with `_`.
pub(super) fn is_c_macro(word: &str) -> bool {
    is_in(C_MACROS, word)
}

/// Whether `<word.h>` is a header of C's own.
pub(super) fn is_c_header(word: &str) -> bool {
    is_in(C_HEADERS, word)
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
