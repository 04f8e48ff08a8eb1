// Pinocchio's C++ behind the driver, from its headers alone.
#include "robot.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "driver.h"

#include <memory>
#include <vector>

namespace pin = pinocchio;

static Model<double> model;
static std::unique_ptr<Data<double>> data;
static std::vector<Eigen::VectorXd> q, v, tau, a;

static int put(double *out, const Eigen::MatrixXd &matrix)
{
    for (Eigen::Index i = 0; i < matrix.rows(); i++)
        for (Eigen::Index j = 0; j < matrix.cols(); j++) *out++ = matrix(i, j);
    return int(matrix.size());
}

// Pinocchio fills the upper triangle.
static Eigen::MatrixXd whole(const Eigen::MatrixXd &upper) { return upper.selfadjointView<Eigen::Upper>(); }

static void run_mass(int s) { pin::crba(model, *data, q[s]); }
static void run_bias(int s) { pin::nonLinearEffects(model, *data, q[s], v[s]); }
static void run_both(int s) { run_mass(s), run_bias(s); }
static void run_forward(int s) { pin::aba(model, *data, q[s], v[s], tau[s]); }
static void run_inverse_by(int s) { pin::computeRNEADerivatives(model, *data, q[s], v[s], a[s]); }
static void run_forward_by(int s) { pin::computeABADerivatives(model, *data, q[s], v[s], tau[s]); }

static int fetch_mass(double *out) { return put(out, whole(data->M)); }
static int fetch_bias(double *out) { return put(out, data->nle); }
static int fetch_both(double *out)
{
    int count = fetch_mass(out);
    return count + fetch_bias(out + count);
}
static int fetch_forward(double *out) { return put(out, data->ddq); }
static int fetch_inverse_by(double *out)
{
    int count = put(out, data->dtau_dq);
    return count + put(out + count, data->dtau_dv);
}
static int fetch_forward_by(double *out)
{
    int count = put(out, data->ddq);
    count += put(out + count, data->ddq_dq);
    count += put(out + count, data->ddq_dv);
    return count + put(out + count, whole(data->Minv));
}

int main(int count, char **arguments)
{
    static const task tasks[] = {
        { "mass", run_mass, fetch_mass },
        { "bias", run_bias, fetch_bias },
        { "both", run_both, fetch_both },
        { "forward", run_forward, fetch_forward },
        { "inverse_by", run_inverse_by, fetch_inverse_by },
        { "forward_by", run_forward_by, fetch_forward_by },
    };
    if (count != 3) return 2;
    model = read_robot<double>(arguments[2]);
    data = std::make_unique<Data<double>>(model);
    read_states(arguments[1], model.nq + 3 * model.nv);
    for (const double *row : states) {
        q.push_back(Eigen::Map<const Eigen::VectorXd>(row, model.nq));
        v.push_back(Eigen::Map<const Eigen::VectorXd>(row += model.nq, model.nv));
        tau.push_back(Eigen::Map<const Eigen::VectorXd>(row += model.nv, model.nv));
        a.push_back(Eigen::Map<const Eigen::VectorXd>(row += model.nv, model.nv));
    }
    return serve(tasks, sizeof tasks / sizeof *tasks);
}
