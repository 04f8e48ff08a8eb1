// A robot for Pinocchio's headers, from the text that `robots.py` writes: no library is linked, so that all
// of Pinocchio is compiled with the flags of this program.
#ifndef ROBOT_HPP
#define ROBOT_HPP

#include <pinocchio/multibody.hpp>

#include <fstream>
#include <stdexcept>
#include <string>

// The joints that the three robots have, and one that follows another, which Pinocchio asks for. Its default
// has twenty-five kinds, and with them its algorithms take a compiler ten minutes and five gigabytes.
template <typename S, int Options_>
struct FewJoints {
    typedef S Scalar;
    static constexpr int Options = Options_;
    typedef boost::variant<
        pinocchio::JointModelRevoluteTpl<S, Options_, 0>, pinocchio::JointModelRevoluteTpl<S, Options_, 1>,
        pinocchio::JointModelRevoluteTpl<S, Options_, 2>, pinocchio::JointModelFreeFlyerTpl<S, Options_>,
        boost::recursive_wrapper<pinocchio::JointModelMimicTpl<S, Options_, ::FewJoints>>>
        JointModelVariant;
    typedef boost::variant<
        pinocchio::JointDataRevoluteTpl<S, Options_, 0>, pinocchio::JointDataRevoluteTpl<S, Options_, 1>,
        pinocchio::JointDataRevoluteTpl<S, Options_, 2>, pinocchio::JointDataFreeFlyerTpl<S, Options_>,
        boost::recursive_wrapper<pinocchio::JointDataMimicTpl<S, Options_, ::FewJoints>>>
        JointDataVariant;
};

template <typename S>
using Model = pinocchio::ModelTpl<S, 0, FewJoints>;
template <typename S>
using Data = pinocchio::DataTpl<S, 0, FewJoints>;

// The joint of a kind as Pinocchio calls it.
template <typename S>
pinocchio::JointModelTpl<S, 0, FewJoints> joint_of(const std::string &kind)
{
    if (kind == "JointModelRX") return pinocchio::JointModelRevoluteTpl<S, 0, 0>();
    if (kind == "JointModelRY") return pinocchio::JointModelRevoluteTpl<S, 0, 1>();
    if (kind == "JointModelRZ") return pinocchio::JointModelRevoluteTpl<S, 0, 2>();
    if (kind == "JointModelFreeFlyer") return pinocchio::JointModelFreeFlyerTpl<S, 0>();
    throw std::runtime_error("no joint of kind " + kind + " is known here");
}

// One line per joint: parent, kind, placement (rotation by rows, translation), mass, centre of mass, inertia
// about it (xx, xy, yy, xz, yz, zz).
template <typename S>
Model<S> read_robot(const std::string &path)
{
    std::ifstream file(path);
    Model<S> model;
    std::size_t parent;
    std::string kind;
    while (file >> parent >> kind) {
        double numbers[22];
        for (double &number : numbers) file >> number;
        if (!file) throw std::runtime_error(path + ": a joint is not whole");
        const double *x = numbers;
        typename pinocchio::SE3Tpl<S>::Matrix3 rotation;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) rotation(i, j) = *x++;
        typename pinocchio::SE3Tpl<S>::Vector3 translation, center;
        for (int i = 0; i < 3; i++) translation(i) = *x++;
        const double mass = *x++;
        for (int i = 0; i < 3; i++) center(i) = *x++;
        const pinocchio::Symmetric3Tpl<S> inertia(x[0], x[1], x[2], x[3], x[4], x[5]);
        const auto joint = model.addJoint(parent, joint_of<S>(kind), pinocchio::SE3Tpl<S>(rotation, translation),
                                          "joint" + std::to_string(model.njoints));
        model.appendBodyToJoint(joint, pinocchio::InertiaTpl<S>(mass, center, inertia),
                                pinocchio::SE3Tpl<S>::Identity());
    }
    return model;
}

#endif
