use proptest::prelude::*;

use super::*;

type D1 = Dual<f64, 1>;

/// Derivative of `f` at `x` by a dual number and by central differences.
fn both(f: impl Fn(D1) -> D1, x: f64) -> (f64, f64) {
    let value = |x: f64| f(D1::constant(x)).re;
    let h = 1e-5;
    let difference = (8.0 * (value(x + h) - value(x - h))
        - (value(x + 2.0 * h) - value(x - 2.0 * h)))
        / (12.0 * h);
    (f(D1::variable(x, 0)).eps[0], difference)
}

proptest! {
    #![proptest_config(crate::property_tests())]

    #[test]
    fn derivatives_agree_with_finite_differences(x in 0.1..0.9_f64) {
        let c = D1::from_f64;
        let cases: [(&str, (f64, f64)); 18] = [
            ("sqrt", both(Scalar::sqrt, x)),
            ("sin", both(Scalar::sin, x)),
            ("cos", both(Scalar::cos, x)),
            ("tan", both(Scalar::tan, x)),
            ("asin", both(Scalar::asin, x)),
            ("acos", both(Scalar::acos, x)),
            ("atan", both(Scalar::atan, x)),
            ("atan2", both(|x| (x * x).atan2(c(0.3) - x), x)),
            ("exp", both(Scalar::exp, x)),
            ("ln", both(Scalar::ln, x)),
            ("powf", both(|x| x.powf(x + c(0.5)), x)),
            ("powi", both(|x| (-x).powi(-3), x)),
            ("tanh", both(Scalar::tanh, x)),
            ("abs", both(|x| (x - c(1.0)).abs(), x)),
            ("min", both(|x| (x * x).min(c(5.0)), x)),
            ("max", both(|x| (x * x).max(c(-5.0)), x)),
            ("mul_add", both(|x| x.mul_add(x.sin(), x / (x + c(2.0))), x)),
            ("quotient", both(|x| (x * x - c(3.0)) / (x.exp() + c(1.0)), x)),
        ];
        for (name, (dual, difference)) in cases {
            prop_assert!(
                (dual - difference).abs() < 1e-8 * (1.0 + difference.abs()),
                "{}: {} against {}", name, dual, difference
            );
        }
    }

    /// Against the independent crate `num-dual`, to round-off.
    #[test]
    fn agrees_with_num_dual(x in 0.1..2.0_f64, y in -2.0..2.0_f64) {
        use num_dual::{Dual64, DualNum};
        fn ours(x: D1, y: D1) -> D1 {
            (x.sin() * y.exp() + x.powf(y)).tanh() / (x.ln() - y.atan2(x)).mul_add(y, D1::from_f64(9.0))
        }
        fn other(x: Dual64, y: Dual64) -> Dual64 {
            (x.sin() * y.exp() + (x.ln() * y).exp()).tanh() / ((x.ln() - y.atan2(x)) * y + 9.0)
        }
        let a = ours(D1::variable(x, 0), D1::constant(y));
        let b = other(Dual64::from(x).derivative(), Dual64::from(y));
        prop_assert!((a.re - b.re).abs() < 1e-14 && (a.eps[0] - b.eps).abs() < 1e-13);
        let a = ours(D1::constant(x), D1::variable(y, 0));
        let b = other(Dual64::from(x), Dual64::from(y).derivative());
        prop_assert!((a.eps[0] - b.eps).abs() < 1e-13);
    }
}

#[test]
fn second_derivatives_by_nesting() {
    let x = Dual {
        re: Dual::<f64, 1>::variable(0.7, 0),
        eps: [Dual::constant(1.0)],
    };
    let y = x.sin() * x.exp();
    let exact = 2.0 * 0.7_f64.cos() * 0.7_f64.exp();
    assert!((y.eps[0].eps[0] - exact).abs() < 1e-14);
}

#[test]
fn selection_carries_the_derivative_of_the_chosen() {
    let [x, y] = Dual::variables([2.0, 3.0]);
    assert_eq!(x.max(y).eps, [0.0, 1.0]);
    assert_eq!(x.min(y).eps, [1.0, 0.0]);
    assert_eq!((-x).select_positive(x, y).eps, [0.0, 1.0]);
    assert_eq!(x.abs().eps, [1.0, 0.0]);
    assert_eq!((-x).abs().eps, [1.0, 0.0]);
    assert_eq!((x.sign().eps, x.step().eps), ([0.0; 2], [0.0; 2]));
    assert!(D1::constant(f64::NAN).max(D1::one()).re.is_nan());
    assert!(D1::one().min(D1::constant(f64::NAN)).re.is_nan());
}

#[test]
fn powers_at_awkward_places() {
    assert_eq!(
        D1::variable(0.0, 0).powi(1),
        D1 {
            re: 0.0,
            eps: [1.0]
        }
    );
    assert_eq!(
        D1::variable(0.0, 0).powi(0),
        D1 {
            re: 1.0,
            eps: [0.0]
        }
    );
    assert_eq!(
        D1::variable(0.0, 0).powf(D1::from_f64(2.0)),
        D1 {
            re: 0.0,
            eps: [0.0]
        }
    );
    assert_eq!(
        D1::variable(-3.0, 0).powf(D1::from_f64(2.0)),
        D1 {
            re: 9.0,
            eps: [-6.0]
        }
    );
}
