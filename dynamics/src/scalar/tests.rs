use super::*;

#[test]
fn sign_step_min_max_hand_nan_on() {
    let x = <f64 as Scalar>::from_f64(-2.0);
    assert_eq!((x.sign(), 0.0.sign(), 3.0.sign()), (-1.0, 0.0, 1.0));
    assert_eq!((x.step(), 0.0.step(), 3.0.step()), (0.0, 0.0, 1.0));
    assert!(Scalar::sign(f64::NAN).is_nan() && Scalar::step(f64::NAN).is_nan());
    assert!(Scalar::max(f64::NAN, 1.0).is_nan() && Scalar::max(1.0, f64::NAN).is_nan());
    assert!(Scalar::min(f64::NAN, 1.0).is_nan() && Scalar::min(1.0, f64::NAN).is_nan());
    assert_eq!((Scalar::max(1.0, 2.0), Scalar::min(1.0, 2.0)), (2.0, 1.0));
    assert_eq!(x.select_positive(1.0, 5.0), 5.0);
    assert_eq!(0.0.select_positive(1.0, 5.0), 5.0);
}

#[test]
fn integer_powers() {
    for n in -9..=9 {
        let (ours, other) = (Scalar::powi(1.3_f64, n), 1.3_f64.powf(f64::from(n)));
        assert!((ours / other - 1.0).abs() < 2e-15, "{n}");
    }
    assert_eq!(Scalar::powi(0.0_f64, 0), 1.0);
    assert_eq!(Scalar::powi(-1.0_f64, i32::MIN), 1.0);
    assert_eq!(Scalar::powi(2.0_f64, i32::MAX), f64::INFINITY);
}

/// Every elementary function against the standard library.
#[test]
fn elementary_functions_agree_with_std() {
    for k in 1..2000 {
        let x = f64::from(k) * 0.0123;
        let unit = (x / 25.0).min(1.0);
        let pairs = [
            (Scalar::sin(x), f64::sin(x)),
            (Scalar::cos(x), f64::cos(x)),
            (Scalar::tan(unit), f64::tan(unit)),
            (Scalar::asin(unit), f64::asin(unit)),
            (Scalar::acos(unit), f64::acos(unit)),
            (Scalar::atan(x), f64::atan(x)),
            (Scalar::atan2(x, -3.0), f64::atan2(x, -3.0)),
            (Scalar::exp(x), f64::exp(x)),
            (Scalar::ln(x), f64::ln(x)),
            (Scalar::powf(x, 1.7), f64::powf(x, 1.7)),
            (Scalar::tanh(x), f64::tanh(x)),
            (Scalar::sqrt(x), f64::sqrt(x)),
            (Scalar::mul_add(x, 2.0, 1.0), 2.0 * x + 1.0),
        ];
        for (i, (ours, std)) in pairs.into_iter().enumerate() {
            assert!(
                (ours - std).abs() <= 4e-16 * std.abs().max(1e-3),
                "{i}: {ours} {std}"
            );
        }
    }
}

#[cfg(feature = "simd")]
mod lanes {
    use super::*;
    use std::vec::Vec;

    use wide::{f32x8, f32x16, f64x4, f64x8};

    /// Distance in units of the last place of `exact`.
    fn ulps(value: f64, exact: f64, digits: i32) -> f64 {
        let exponent = exact.abs().max(1e-300).log2().floor() as i32;
        (value - exact).abs() / 2.0_f64.powi(exponent - digits + 1)
    }

    macro_rules! sin_cos_within {
        ($name:ident, $lanes:ident, $element:ident, $digits:literal, $count:literal, $range:expr) => {
            #[test]
            fn $name() {
                let mut worst: f64 = 0.0;
                let mut x = -$range;
                while x < $range {
                    let lanes: [$element; $count] =
                        core::array::from_fn(|i| ((x + 0.001 * i as f64) as $element));
                    let (s, c) = Scalar::sin_cos($lanes::from(lanes));
                    for (i, x) in lanes.into_iter().enumerate() {
                        let (s, c) = (s.to_array()[i] as f64, c.to_array()[i] as f64);
                        // f64 is compared to libm, itself within half a unit or so.
                        let (es, ec) = f64::from(x).sin_cos();
                        worst = worst.max(ulps(s, es, $digits)).max(ulps(c, ec, $digits));
                    }
                    x += $range / 20_011.0;
                }
                std::println!("{}: {worst:.3} ulp on ±{}", stringify!($lanes), $range);
                assert!(worst < 2.1, "{worst}");
            }
        };
    }

    sin_cos_within!(sin_cos_f64x4_near, f64x4, f64, 53, 4, 10.0);
    sin_cos_within!(sin_cos_f64x4_far, f64x4, f64, 53, 4, 0.99e6);
    sin_cos_within!(sin_cos_f64x8_near, f64x8, f64, 53, 8, 10.0);
    sin_cos_within!(sin_cos_f64x8_beyond, f64x8, f64, 53, 8, 1e12);
    sin_cos_within!(sin_cos_f32x8_near, f32x8, f32, 24, 8, 10.0);
    sin_cos_within!(sin_cos_f32x8_far, f32x8, f32, 24, 8, 3.9e3);
    sin_cos_within!(sin_cos_f32x16_near, f32x16, f32, 24, 16, 10.0);
    sin_cos_within!(sin_cos_f32x16_beyond, f32x16, f32, 24, 16, 1e6);

    #[test]
    fn sin_cos_at_multiples_of_a_quarter_turn_and_not_finite() {
        for k in -4000_i32..4000 {
            let x = f64::from(k) * core::f64::consts::FRAC_PI_4;
            let (s, c) = Scalar::sin_cos(f64x4::splat(x));
            let (es, ec) = x.sin_cos();
            assert!((s.to_array()[0] - es).abs() < 2e-16, "{x}");
            assert!((c.to_array()[0] - ec).abs() < 2e-16, "{x}");
        }
        let (s, c) = Scalar::sin_cos(f64x4::from([f64::NAN, f64::INFINITY, 0.0, -0.0]));
        assert!(
            s.to_array()[..2]
                .iter()
                .chain(&c.to_array()[..2])
                .all(|x| x.is_nan())
        );
        assert_eq!((s.to_array()[2], c.to_array()[3]), (0.0, 1.0));
    }

    /// Lanes against the scalar type, function by function.
    #[test]
    fn lanes_follow_the_scalar() {
        type Function = (&'static str, fn(f64) -> f64, fn(f64x4) -> f64x4);
        macro_rules! both {
            ($($name:literal $f:expr;)*) => {{
                fn list() -> Vec<Function> {
                    std::vec![$(($name, |x| { let f = $f; f(x) }, |x| { let f = $f; f(x) })),*]
                }
                list()
            }};
        }
        let functions = both! {
            "exp" Scalar::exp;
            "ln" |x| Scalar::ln(Scalar::abs(x));
            "sqrt" |x| Scalar::sqrt(Scalar::abs(x));
            "tan" Scalar::tan;
            "asin" Scalar::asin;
            "acos" Scalar::acos;
            "atan" Scalar::atan;
            "atan2" |x| Scalar::atan2(x, Scalar::from_f64(-0.3));
            "powf" |x| Scalar::powf(Scalar::abs(x), Scalar::from_f64(1.7));
            "powi" |x| Scalar::powi(x, -3);
            "tanh" Scalar::tanh;
            "sign" Scalar::sign;
            "step" Scalar::step;
            "min" |x| Scalar::min(x, Scalar::from_f64(0.2));
            "max" |x| Scalar::max(x, Scalar::from_f64(0.2));
            "select" |x| Scalar::select_positive(x, Scalar::from_f64(4.0), x);
        };
        let inputs = [
            -2.5,
            -1.0,
            -0.3,
            0.0,
            1e-9,
            0.2,
            0.7,
            1.0,
            3.0,
            f64::NAN,
            50.0,
            -700.0,
        ];
        for (name, scalar, lanes) in functions {
            for group in inputs.chunks(4) {
                let packed: [f64; 4] = core::array::from_fn(|i| group[i]);
                let values = lanes(f64x4::from(packed)).to_array();
                for (x, value) in packed.into_iter().zip(values) {
                    let exact = scalar(x);
                    let same = value == exact
                        || (value.is_nan() && exact.is_nan())
                        || ulps(value, exact, 53) < 5.0;
                    assert!(same, "{name}({x}): {value} against {exact}");
                }
            }
        }
    }

    #[test]
    #[ignore = "prints timings; run by hand in release"]
    fn timings() {
        use std::hint::black_box;
        let start = std::time::Instant::now();
        let mut x = f64x8::splat(0.1);
        for _ in 0..1_000_000 {
            let (s, c) = Scalar::sin_cos(black_box(x));
            x += s * c;
        }
        let ours = start.elapsed();
        let start = std::time::Instant::now();
        for _ in 0..1_000_000 {
            let (s, c) = f64x8::sin_cos(black_box(x));
            x += s * c;
        }
        let wide = start.elapsed();
        let start = std::time::Instant::now();
        let mut y = 0.1_f64;
        for _ in 0..1_000_000 {
            let (s, c) = f64::sin_cos(black_box(y));
            y += s * c;
        }
        let std = start.elapsed();
        let start = std::time::Instant::now();
        for _ in 0..1_000_000 {
            let (s, c) = Scalar::sin_cos(black_box(y));
            y += s * c;
        }
        let scalar = start.elapsed();
        black_box((x, y));
        std::println!(
            "1e6 calls: own f64x8 {ours:?}, wide f64x8 {wide:?}, std f64 {std:?}, Scalar f64 {scalar:?}"
        );
    }
}
