//! Generated code and the run-time cannot panic and do not allocate: the release object that
//! holds every emitted function, in `f64` and `f32`, and the constrained solve, leaves
//! nothing to others but arithmetic.

use integration_tests::files::root;
use integration_tests::object_code::{Libraries, Symbols};
use proc_macro2::{Group, Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Moves and fills of memory, which compilers call by themselves.
const MEMORY: [&str; 4] = ["memcpy", "memmove", "memset", "memcmp"];

/// How errors write what they are. Only who prints one calls it, and a panic with a message
/// would want `core::panicking` besides.
fn is_text(name: &str) -> bool {
    name.starts_with("core::fmt::")
        || name.starts_with("<core::fmt::Formatter>::")
        || name.contains(" as core::fmt::")
}

/// Nothing else may be wanted. `libm` checks the bounds of a table inside, which no
/// argument reaches (its own tests), and has no other way to fail.
fn is_arithmetic(name: &str) -> bool {
    MEMORY.contains(&name) || name.starts_with("libm::")
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("object_symbols");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn libraries() -> &'static Libraries {
    static LIBRARIES: OnceLock<Libraries> = OnceLock::new();
    LIBRARIES.get_or_init(|| {
        Libraries::build(
            &root(),
            &["generated", "eqmotion"],
            &folder().join("target"),
        )
    })
}

/// What `source` and the crates under test want from others, beyond arithmetic.
fn strangers(name: &str, source: &str) -> Vec<String> {
    let object = folder().join(name);
    libraries().compile(source, &["dynamics", "generated"], &object);
    let mut symbols = Symbols::default();
    symbols.add(&object);
    symbols.add(libraries().path("dynamics"));
    symbols.add(libraries().path("generated"));
    let found = symbols.strangers(|name| is_arithmetic(name) || is_text(name));
    found.into_iter().map(str::to_owned).collect()
}

/// `T` made a type of numbers.
fn with_number(tokens: TokenStream, number: &str) -> TokenStream {
    let replaced = tokens.into_iter().map(|token| match token {
        TokenTree::Ident(ident) if ident == "T" => Ident::new(number, Span::call_site()).into(),
        TokenTree::Group(group) => {
            let inside = with_number(group.stream(), number);
            TokenTree::Group(Group::new(group.delimiter(), inside))
        }
        other => other,
    });
    replaced.collect()
}

/// A generated module, as the test reads it.
struct Module {
    name: Ident,
    functions: Vec<syn::Signature>,
    /// `System<T, N, U, M, Z>` and who implements it.
    system: TokenStream,
    sizes: Vec<TokenStream>,
    model: TokenStream,
}

impl Module {
    fn read(path: &Path) -> Self {
        let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
        let functions = file.items.iter().filter_map(|item| match item {
            // A part of a long function is private, and comes with it.
            syn::Item::Fn(function) => {
                matches!(function.vis, syn::Visibility::Public(_)).then(|| function.sig.clone())
            }
            _ => None,
        });
        let system = file.items.iter().find_map(|item| match item {
            syn::Item::Impl(item) => {
                let (path, _) = item.trait_.as_ref()?;
                let last = path.segments.last()?;
                let syn::PathArguments::AngleBracketed(arguments) = &last.arguments else {
                    return None;
                };
                let sizes = arguments.args.iter().skip(1).map(|a| a.to_token_stream());
                let path = path.to_token_stream();
                (last.ident == "System")
                    .then(|| (path, sizes.collect(), item.self_ty.to_token_stream()))
            }
            _ => None,
        });
        let (system, sizes, model) = system.expect("a module implements `System`");
        Self {
            name: format_ident!("{}", path.file_stem().unwrap().to_str().unwrap()),
            functions: functions.collect(),
            system,
            sizes,
            model,
        }
    }

    /// A module with every function for one type of numbers, none of them inlined away.
    fn instances(&self, number: &str, solve: bool) -> TokenStream {
        let (name, model, system) = (&self.name, &self.model, &self.system);
        let number_type = Ident::new(number, Span::call_site());
        let functions = self.functions.iter().map(|signature| {
            let (function, inputs, output) =
                (&signature.ident, &signature.inputs, &signature.output);
            let arguments = signature.inputs.iter().map(|input| match input {
                syn::FnArg::Typed(input) => input.pat.to_token_stream(),
                syn::FnArg::Receiver(_) => unreachable!("a free function has no receiver"),
            });
            quote! {
                #[inline(never)]
                pub fn #function(#inputs) #output {
                    generated::#name::#function(#(#arguments),*)
                }
            }
        });
        let [n, u, m, z] = &self.sizes[..] else {
            panic!("System<T, N, U, M, Z>")
        };
        let solves = solve.then(|| quote! {
            #[inline(never)]
            pub fn solve_unchecked(s: &#model, x: &Point<T, #n, #u, #z>) -> Solution<T, #n, #m> {
                acceleration_full_rank(s, x, Some(&Baumgarte::critical(10.0)))
            }
            #[inline(never)]
            pub fn solve(s: &#model, x: &Point<T, #n, #u, #z>) -> Result<Solution<T, #n, #m>, SolveError> {
                acceleration(s, x, None, &Tolerance::default())
            }
            #[inline(never)]
            pub fn step(s: &#model, y: &State<T, #n, #z>, u: [T; #u]) -> Result<State<T, #n, #z>, SolveError> {
                Simulation::new(s).rk4_step(0.0, y, 1e-3, |_, _| u)
            }
        });
        let instances = format_ident!("{name}_{number}");
        let body = quote! {
            #(#functions)*
            #[inline(never)]
            pub fn terms(s: &#model, x: &Point<T, #n, #u, #z>) -> (Equation<T, #n, #m>, [T; #z]) {
                (<#model as #system>::equation(s, x), <#model as #system>::state_rate(s, x))
            }
            #solves
        };
        let body = with_number(body, &number_type.to_string());
        quote! {
            pub mod #instances {
                use dynamics::constrained::{Baumgarte, SolveError, Solution, Tolerance};
                use dynamics::integrate::State;
                use dynamics::{Equation, Point, Simulation, System, acceleration, acceleration_full_rank};
                use generated::#name::*;
                #body
            }
        }
    }
}

fn modules() -> Vec<Module> {
    let entries = std::fs::read_dir(root().join("generated/src")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.file_name().unwrap() != "lib.rs");
    paths.sort();
    assert!(paths.len() >= 8);
    paths.iter().map(|path| Module::read(path)).collect()
}

#[test]
fn generated_code_leaves_nothing_but_arithmetic_to_others() {
    if left_out::too_slow() {
        return;
    }
    let mut sizes = BTreeSet::new();
    let mut source = TokenStream::new();
    for module in modules() {
        // The solve depends on the sizes, not on the model.
        let own = module
            .sizes
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>();
        let solve = sizes.insert(own);
        source.extend(module.instances("f64", solve));
        source.extend(module.instances("f32", solve));
    }
    let source = format!("#![no_std]\n#![allow(warnings)]\n{source}");
    let found = strangers("generated.o", &source);
    assert!(
        found.is_empty(),
        "called from others:\n  {}",
        found.join("\n  ")
    );
}

/// A function beside generated code that the test must find fault with.
fn injected(name: &str, function: &str) -> String {
    let source = format!("#![no_std]\n{function}");
    strangers(name, &source).join("\n")
}

#[test]
fn a_panic_is_found() {
    if left_out::too_slow() {
        return;
    }
    let index = "#[inline(never)] pub fn f(x: &[f64], i: usize) -> f64 { x[i] }";
    assert!(injected("index.o", index).contains("panic_bounds_check"));
    let unwrap = "#[inline(never)] pub fn f(x: Option<f64>) -> f64 { x.unwrap() }";
    assert!(injected("unwrap.o", unwrap).contains("unwrap_failed"));
    let divide = "#[inline(never)] pub fn f(a: u32, b: u32) -> u32 { a / b }";
    assert!(injected("divide.o", divide).contains("div_by_zero"));
    // Inside a generated function: an index that depends on data.
    let matrix = "
        use dynamics::Point;
        use generated::pendulum::{Parameters, mass_matrix};
        #[inline(never)]
        pub fn f(p: &Parameters<f64>, x: &Point<f64, 1, 1, 0>, i: usize) -> f64 { mass_matrix(p, x)[i][0] }";
    assert!(injected("matrix.o", matrix).contains("panic_bounds_check"));
}

#[test]
fn an_allocation_is_found() {
    if left_out::too_slow() {
        return;
    }
    let boxed = "extern crate alloc;
        #[inline(never)] pub fn f(x: f64) -> alloc::boxed::Box<f64> { alloc::boxed::Box::new(x) }";
    assert!(injected("boxed.o", boxed).contains("alloc"));
}

#[test]
fn clean_code_is_not() {
    if left_out::too_slow() {
        return;
    }
    let sum = "#[inline(never)] pub fn f(x: &[f64]) -> f64 { x.iter().sum() }";
    assert_eq!(injected("sum.o", sum), "");
}
