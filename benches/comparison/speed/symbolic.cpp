// Pinocchio's algorithms over CasADi's expressions: prints one serialised function.
//
//     symbolic ROBOT.txt FUNCTION
#include <pinocchio/autodiff/casadi.hpp>

#include "robot.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <iostream>

namespace pin = pinocchio;
using casadi::SX;
using Matrix = Eigen::Matrix<SX, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;

static SX of(const Matrix &matrix)
{
    SX found(matrix.rows(), matrix.cols());
    pin::casadi::copy(matrix, found);
    return SX::densify(found);
}

static Vector vector_of(const SX &symbols)
{
    Vector found(symbols.size1());
    pin::casadi::copy(symbols, found);
    return found;
}

static Matrix whole(const Matrix &upper)
{
    Matrix found = upper;
    for (Eigen::Index i = 0; i < upper.rows(); i++)
        for (Eigen::Index j = 0; j < i; j++) found(i, j) = upper(j, i);
    return found;
}

int main(int count, char **arguments)
{
    if (count != 3) return 2;
    const Model<SX> model = read_robot<SX>(arguments[1]);
    Data<SX> data(model);
    const std::string name = arguments[2];
    const SX q = SX::sym("q", model.nq), v = SX::sym("v", model.nv), x = SX::sym("x", model.nv);
    const Vector eq = vector_of(q), ev = vector_of(v), ex = vector_of(x);
    std::vector<SX> inputs{ q, v, x }, results;
    if (name == "mass" || name == "both") {
        pin::crba(model, data, eq);
        results.push_back(of(whole(data.M)));
    }
    if (name == "bias" || name == "both") {
        pin::nonLinearEffects(model, data, eq, ev);
        results.push_back(of(data.nle));
    }
    if (name == "forward") {
        pin::aba(model, data, eq, ev, ex);
        results.push_back(of(data.ddq));
    }
    if (name == "inverse_by") {
        pin::computeRNEADerivatives(model, data, eq, ev, ex);
        results = { of(data.dtau_dq), of(data.dtau_dv) };
    }
    if (name == "forward_by") {
        pin::computeABADerivatives(model, data, eq, ev, ex);
        results = { of(data.ddq), of(data.ddq_dq), of(data.ddq_dv), of(whole(data.Minv)) };
    }
    if (results.empty()) return 2;
    std::cout << casadi::Function(name, inputs, results).serialize();
    return 0;
}
