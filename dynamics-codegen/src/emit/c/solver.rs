//! The loops with which functions of many coordinates solve, as static functions of the file.

use super::{Lines, Unit, comment};

/// `M = Lᵀ D L`, eliminated from the last row to the first along the ways to the root, and
/// what solves with it.
const FACTOR: &str = "\
/* Matrix = L' D L in place, with 1 / D in inverse; parents lead to the root of each row. */
static void PREFIX_factor(int n, const int *parents, REAL_TYPE *matrix, REAL_TYPE *inverse)
{
    for (int k = n - 1; k >= 0; k--) {
        REAL_TYPE *row = matrix + k * n;
        inverse[k] = REAL(1.0) / row[k];
        for (int i = parents[k]; i >= 0; i = parents[i]) {
            const REAL_TYPE share = row[i] * inverse[k];
            for (int j = i; j >= 0; j = parents[j]) {
                matrix[i * n + j] -= share * row[j];
            }
            row[i] = share;
        }
    }
}

/* Matrix^-1 x in place of x, for so many columns. */
static void PREFIX_divide(
    int n, const int *parents, const REAL_TYPE *lower, const REAL_TYPE *inverse,
    int columns, REAL_TYPE *x)
{
    for (int k = n - 1; k >= 0; k--) {
        for (int i = parents[k]; i >= 0; i = parents[i]) {
            const REAL_TYPE share = lower[k * n + i];
            for (int c = 0; c < columns; c++) {
                x[i * columns + c] -= share * x[k * columns + c];
            }
        }
    }
    for (int k = 0; k < n; k++) {
        for (int c = 0; c < columns; c++) {
            x[k * columns + c] *= inverse[k];
        }
        for (int i = parents[k]; i >= 0; i = parents[i]) {
            const REAL_TYPE share = lower[k * n + i];
            for (int c = 0; c < columns; c++) {
                x[k * columns + c] -= share * x[i * columns + c];
            }
        }
    }
}
";

/// What the constraints take besides.
const PRODUCT: &str = "\
/* x + sign A y in place of x, for a matrix A of so many rows. */
static void PREFIX_add_product(
    int rows, int inner, int columns, REAL_TYPE sign,
    const REAL_TYPE *a, const REAL_TYPE *y, REAL_TYPE *x)
{
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < inner; k++) {
            const REAL_TYPE share = sign * a[i * inner + k];
            for (int c = 0; c < columns; c++) {
                x[i * columns + c] += share * y[k * columns + c];
            }
        }
    }
}
";

/// Copies.
const SCALE: &str = "\
/* Sign times as many numbers. */
static void PREFIX_scale(int length, REAL_TYPE sign, const REAL_TYPE *from, REAL_TYPE *to)
{
    for (int i = 0; i < length; i++) {
        to[i] = sign * from[i];
    }
}
";

/// The motion without constraints.
const MOTION: &str = "\
/* The terms, with the factors of M in its place, and the motion. */
typedef struct PREFIX_motion {
    PREFIX_equation terms;
    REAL_TYPE inverse[SIZE];
    REAL_TYPE a[SIZE];
} PREFIX_motion;

static void PREFIX_move_freely(const PREFIX_parameters *p, const PREFIX_point *x, PREFIX_motion *w)
{
    PREFIX_equation_of_motion(p, x, &w->terms);
    PREFIX_factor(SIZE, PREFIX_parents, &w->terms.mass_matrix[0][0], w->inverse);
    PREFIX_scale(SIZE, REAL(1.0), w->terms.force, w->a);
    PREFIX_divide(SIZE, PREFIX_parents, &w->terms.mass_matrix[0][0], w->inverse, 1, w->a);
}
";

/// The motion under constraints, and what solves for its derivatives.
const CONSTRAINED: &str = "\
/* The response Y = M^-1 A' to the rows of A, the factors of A Y, and the multipliers. */
typedef struct PREFIX_held {
    PREFIX_motion free;
    REAL_TYPE response[SIZE][ROWS];
    REAL_TYPE gram[ROWS][ROWS];
    REAL_TYPE inverse[ROWS];
    REAL_TYPE lambda[ROWS];
} PREFIX_held;

/* x, y of M x - A' y = r, A x = s from x = M^-1 r, y = s, for so many columns. */
static void PREFIX_hold(const PREFIX_held *w, int columns, REAL_TYPE *x, REAL_TYPE *y)
{
    const REAL_TYPE *rows = &w->free.terms.constraint_jacobian[0][0];
    PREFIX_add_product(ROWS, SIZE, columns, REAL(-1.0), rows, x, y);
    PREFIX_divide(ROWS, PREFIX_chain, &w->gram[0][0], w->inverse, columns, y);
    PREFIX_add_product(SIZE, ROWS, columns, REAL(1.0), &w->response[0][0], y, x);
}

static void PREFIX_move_held(const PREFIX_parameters *p, const PREFIX_point *x, PREFIX_held *w)
{
    const PREFIX_equation *terms = &w->free.terms;
    const REAL_TYPE *mass = &terms->mass_matrix[0][0];
    PREFIX_move_freely(p, x, &w->free);
    for (int i = 0; i < SIZE; i++) {
        for (int k = 0; k < ROWS; k++) {
            w->response[i][k] = terms->constraint_jacobian[k][i];
        }
    }
    for (int k = 0; k < ROWS; k++) {
        for (int l = 0; l < ROWS; l++) {
            w->gram[k][l] = REAL(0.0);
        }
    }
    PREFIX_divide(SIZE, PREFIX_parents, mass, w->free.inverse, ROWS, &w->response[0][0]);
    PREFIX_add_product(
        ROWS, SIZE, ROWS, REAL(1.0), &terms->constraint_jacobian[0][0],
        &w->response[0][0], &w->gram[0][0]);
    PREFIX_factor(ROWS, PREFIX_chain, &w->gram[0][0], w->inverse);
    PREFIX_scale(ROWS, REAL(1.0), terms->constraint_bias, w->lambda);
    PREFIX_hold(w, 1, w->free.a, w->lambda);
}
";

impl Unit<'_> {
    /// The tables and functions that the functions in loops call, if there are any.
    pub(super) fn solver(&self, w: &mut Lines) {
        let mut solved = self.plan.functions.iter().filter_map(|f| f.solved.as_ref());
        if !self.plan.solves() {
            return;
        }
        let parents = self.plan.parents.iter().enumerate();
        let parents = parents.map(|(k, &parent)| if parent < k { parent as i64 } else { -1 });
        let text = "For each coordinate the one that carries it, or -1.";
        self.table(w, text, "parents", parents.collect());
        let holds = solved.any(|solved| solved.constrained);
        if holds {
            let rows = self.plan.model.constraints.len() as i64;
            let chain = (0..rows).map(|k| k - 1).collect();
            self.table(
                w,
                "The same for the constraint rows, each on the one before.",
                "chain",
                chain,
            );
        }
        // A static function that nothing calls is a warning.
        let texts: &[&str] = match holds {
            true => &[FACTOR, PRODUCT, SCALE, MOTION, CONSTRAINED],
            false => &[FACTOR, SCALE, MOTION],
        };
        for text in texts {
            w.text.push_str(&self.fill(text));
            w.blank();
        }
    }

    /// `static const int model_parents[3] = {…};`
    fn table(&self, w: &mut Lines, text: &str, name: &str, entries: Vec<i64>) {
        comment(w, 0, text);
        let (prefix, length) = (&self.prefix, entries.len());
        w.line(&format!("static const int {prefix}_{name}[{length}] = {{"));
        for row in entries.chunks(16) {
            let row: Vec<String> = row.iter().map(i64::to_string).collect();
            w.line(&format!("    {},", row.join(", ")));
        }
        w.line("};");
        w.blank();
    }

    /// A text with this model's names and sizes.
    fn fill(&self, text: &str) -> String {
        let model = &self.plan.model;
        // The sizes first: a model's name may contain what stands for one.
        text.replace("ROWS", &model.constraints.len().to_string())
            .replace("SIZE", &model.coordinates.len().to_string())
            .replace("REAL_TYPE", "PREFIX_real")
            .replace("PREFIX", &self.prefix)
    }
}
