// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/loss_function.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// Dynamic covariance scaling as a loss: quadratic up to phi, then bounded by 3 phi.
class DcsLoss : public ceres::LossFunction {
 public:
  explicit DcsLoss(double phi) : phi_(phi) {}

  void Evaluate(double s, double rho[3]) const override {
    if (s <= phi_) {
      rho[0] = s;
      rho[1] = 1.0;
      rho[2] = 0.0;
      return;
    }
    const double sum = phi_ + s;
    rho[0] = (3.0 * phi_ * s - phi_ * phi_) / sum;
    rho[1] = 4.0 * phi_ * phi_ / (sum * sum);
    rho[2] = -2.0 * rho[1] / sum;
  }

 private:
  double phi_;
};

class GemanMcClureLoss : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double squared_size) : c2_(squared_size) {}

  void Evaluate(double s, double rho[3]) const override {
    const double sum = c2_ + s;
    rho[0] = c2_ * s / sum;
    rho[1] = c2_ * c2_ / (sum * sum);
    rho[2] = -2.0 * rho[1] / sum;
  }

 private:
  double c2_;
};

/// 2 c^2 (r / c - ln(1 + r / c)) of the norm r.
class FairLoss : public ceres::LossFunction {
 public:
  explicit FairLoss(double size) : c_(size) {}

  void Evaluate(double s, double rho[3]) const override {
    const double r = std::sqrt(s);
    const double sum = c_ + r;
    rho[0] = 2.0 * c_ * (r - c_ * std::log1p(r / c_));
    rho[1] = c_ / sum;
    // The second derivative has a pole at zero; only the first one is needed there.
    rho[2] = r > 0.0 ? -0.5 * c_ / (r * sum * sum) : 0.0;
  }

 private:
  double c_;
};

/// 2 c^2 (sqrt(1 + s / c^2) - 1).
class PseudoHuberLoss : public ceres::LossFunction {
 public:
  explicit PseudoHuberLoss(double squared_size) : c2_(squared_size) {}

  void Evaluate(double s, double rho[3]) const override {
    const double root = std::sqrt(1.0 + s / c2_);
    rho[0] = 2.0 * c2_ * (root - 1.0);
    rho[1] = 1.0 / root;
    rho[2] = -0.5 / (c2_ * root * root * root);
  }

 private:
  double c2_;
};

/// Quadratic up to c, constant beyond.
class SaturatedLoss : public ceres::LossFunction {
 public:
  explicit SaturatedLoss(double squared_size) : c2_(squared_size) {}

  void Evaluate(double s, double rho[3]) const override {
    const bool inside = s <= c2_;
    rho[0] = inside ? s : c2_;
    rho[1] = inside ? 1.0 : 0.0;
    rho[2] = 0.0;
  }

 private:
  double c2_;
};

/// Tukey's biweight, c^2 / 3 (1 - (1 - s / c^2)^3) up to c and constant beyond. The class of older
/// versions of Ceres has half of this derivative.
class TukeyLoss : public ceres::LossFunction {
 public:
  explicit TukeyLoss(double squared_size) : c2_(squared_size) {}

  void Evaluate(double s, double rho[3]) const override {
    const double complement = s <= c2_ ? 1.0 - s / c2_ : 0.0;
    rho[0] = c2_ / 3.0 * (1.0 - complement * complement * complement);
    rho[1] = complement * complement;
    rho[2] = -2.0 / c2_ * complement;
  }

 private:
  double c2_;
};

/// c^2 (1 - exp(-s / c^2)).
class WelschLoss : public ceres::LossFunction {
 public:
  explicit WelschLoss(double squared_size) : c2_(squared_size) {}

  void Evaluate(double s, double rho[3]) const override {
    const double decay = std::exp(-s / c2_);
    rho[0] = c2_ * (1.0 - decay);
    rho[1] = decay;
    rho[2] = -decay / c2_;
  }

 private:
  double c2_;
};

}  // namespace

const std::vector<std::pair<std::string, RobustKernel>>& robust_kernel_names() {
  static const std::vector<std::pair<std::string, RobustKernel>> names = {
      {"none", RobustKernel::kNone},
      {"Huber", RobustKernel::kHuber},
      {"PseudoHuber", RobustKernel::kPseudoHuber},
      {"Cauchy", RobustKernel::kCauchy},
      {"DCS", RobustKernel::kDcs},
      {"Fair", RobustKernel::kFair},
      {"GemanMcClure", RobustKernel::kGemanMcClure},
      {"Saturated", RobustKernel::kSaturated},
      {"Tukey", RobustKernel::kTukey},
      {"Welsch", RobustKernel::kWelsch}};
  return names;
}

RobustKernel robust_kernel_of(const std::string& name) {
  std::vector<std::string> names;
  for (const auto& [known, kernel] : robust_kernel_names()) {
    if (lower_case(known) == lower_case(name)) return kernel;
    names.push_back(known);
  }
  throw InputError("'" + name + "' is no robust kernel; there are " + joined(names));
}

std::unique_ptr<ceres::LossFunction> make_kernel(RobustKernel kernel, double size) {
  switch (kernel) {
    case RobustKernel::kNone:
      return nullptr;
    case RobustKernel::kHuber:
      return std::make_unique<ceres::HuberLoss>(size);
    case RobustKernel::kPseudoHuber:
      return std::make_unique<PseudoHuberLoss>(size * size);
    case RobustKernel::kFair:
      return std::make_unique<FairLoss>(size);
    case RobustKernel::kSaturated:
      return std::make_unique<SaturatedLoss>(size * size);
    case RobustKernel::kTukey:
      return std::make_unique<TukeyLoss>(size * size);
    case RobustKernel::kWelsch:
      return std::make_unique<WelschLoss>(size * size);
    case RobustKernel::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(size);
    case RobustKernel::kDcs:
      return std::make_unique<DcsLoss>(size * size);
    case RobustKernel::kGemanMcClure:
      return std::make_unique<GemanMcClureLoss>(size * size);
  }
  return nullptr;
}

double chi2_limit(int degrees_of_freedom) {
  constexpr std::array<double, 6> kQuantiles = {6.635, 9.210, 11.345, 13.277, 15.086, 16.812};
  if (degrees_of_freedom < 1 || degrees_of_freedom > static_cast<int>(kQuantiles.size())) {
    throw InputError("there is no limit for " + std::to_string(degrees_of_freedom) +
                     " degrees of freedom; a constraint has 1 to 6");
  }
  return kQuantiles[static_cast<std::size_t>(degrees_of_freedom - 1)];
}

}  // namespace lidar_mapping::pose_graph
