//! `#[derive(Dynamics)]`: a struct becomes the system that a model file describes.
//!
//! Use it through the crate `dynamics` and its feature `derive`:
//!
//! ```
//! use dynamics::{Dynamics, Point, System};
//!
//! /// The fields stay variable; what else the model has is folded in as numbers.
//! #[derive(Dynamics)]
//! #[dynamics(model = "tests/models/cart.model")]
//! struct Cart<T> {
//!     /// Mass of the cart, kg.
//!     mc: T,
//!     /// Length of the pole, m.
//!     l: T,
//! }
//!
//! let cart = Cart { mc: 2.0, l: 0.4 };
//! let x = Point { t: 0.0, q: [0.0, 0.1], v: [0.0; 2], u: [1.0], z: [] };
//! let terms = cart.equation(&x);
//! assert_eq!(terms.mass_matrix[(0, 0)], 2.1); // with mp = 0.1 from the file
//! assert_eq!(cart.input_matrix(&x), [[1.0], [0.0]]);
//! assert_eq!(Cart::<f64>::COORDINATE_NAMES, ["x", "theta"]);
//! ```
//!
//! # The struct
//!
//! * Fields of one type parameter (`struct Cart<T> { mc: T }`): an
//!   `impl<T: Scalar> System<T, …> for Cart<T>`. With `T` a dual number the derivative
//!   with respect to a field comes out.
//! * Fields of type `f64` or `f32`: an `impl<T: Scalar> System<T, …>` for every `T`, into
//!   which the fields are converted.
//! * No field (`struct Cart;`): everything is folded in.
//!
//! # The attribute
//!
//! | | |
//! |---|---|
//! | `model = "cart.model"` | the model file, relative to the folder of `Cargo.toml` |
//! | `urdf = "arm.urdf"` | in its place a robot description; what may stay variable are the inertial parameters of its links, `<link>_mass`, `<link>_cx`, …, `<link>_iyz` |
//! | `mjcf = "arm.xml"` | the same of MuJoCo's format |
//! | `effects = "effects"` | a folder of effect templates of one's own; may be repeated |
//! | `functions = "full"` | functions beside the terms, as [`dynamics generate --functions`](dynamics_codegen::emit::Functions) takes them: `full`, or names separated by commas such as `inverse_dynamics,forward_dynamics_derivatives`; each becomes a method |
//! | `parameter = "…"`, on a field | the parameter's name, where the field has another |
//!
//! # Frames
//!
//! ```
//! use dynamics::{Dynamics, Point};
//!
//! #[derive(Dynamics)]
//! #[dynamics(urdf = "tests/models/arm.urdf", functions = "frame_position_of_lower, frame_jacobian_of_lower")]
//! struct Arm;
//!
//! let x = Point { q: [0.3, 0.0], v: [2.0, 1.0], ..Point::zero() };
//! // The elbow is 0.4 m below the shoulder, which alone moves it.
//! let [px, _, pz] = Arm.frame_position_of_lower(&x);
//! assert!((px + 0.4 * f64::sin(0.3)).abs() < 1e-15 && (pz + 0.4 * f64::cos(0.3)).abs() < 1e-15);
//! // Rows: velocity x, y, z, then angular velocity; columns: shoulder, elbow.
//! let jacobian: [[f64; 2]; 6] = Arm.frame_jacobian_of_lower(&x);
//! assert!((jacobian[0][Arm::Q_SHOULDER] - pz).abs() < 1e-15 && jacobian[0][Arm::Q_ELBOW] == 0.0);
//! assert_eq!(jacobian[4], [1.0, 1.0]); // both turn it about y
//! ```
//!
//! # What is there then
//!
//! `::dynamics::System`; a method for every further quantity of the model
//! (`bias_force`, `input_matrix`, `constraint_jacobian`, `outputs`, …, each documented with
//! shape and units); `nominal()`, with the values of the file; and the constants
//! `COORDINATES`, `COORDINATE_NAMES`, `Q_THETA` and so on. A change of a file the model was made from
//! builds anew.

mod attribute;
mod door;
mod expand;
mod forward;
mod input;

use proc_macro::TokenStream;

/// Makes a struct the system that a model file describes; see the [crate](self).
#[proc_macro_derive(Dynamics, attributes(dynamics))]
pub fn derive_dynamics(input: TokenStream) -> TokenStream {
    let expanded = syn::parse(input).and_then(|item| expand::expand(&item));
    expanded
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}
