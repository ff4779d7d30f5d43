// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pose_graph/robust_kernel.hpp"

#include <array>
#include <cmath>

#include <ceres/loss_function.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::pose_graph {

namespace {

/// Writes the loss of a squared norm s and its two derivatives to `rho`. The scale is the size c of
/// the kernel, or its square c2.
using Rho = void (*)(double s, double scale, double rho[3]);

class KernelLoss : public ceres::LossFunction {
 public:
  KernelLoss(Rho rho, double scale) : rho_(rho), scale_(scale) {}

  void Evaluate(double s, double rho[3]) const override { rho_(s, scale_, rho); }

 private:
  Rho rho_;
  double scale_;
};

/// Dynamic covariance scaling as a loss: quadratic up to phi, then bounded by 3 phi.
void dcs(double s, double phi, double rho[3]) {
  if (s <= phi) {
    rho[0] = s;
    rho[1] = 1.0;
    rho[2] = 0.0;
    return;
  }
  const double sum = phi + s;
  rho[0] = (3.0 * phi * s - phi * phi) / sum;
  rho[1] = 4.0 * phi * phi / (sum * sum);
  rho[2] = -2.0 * rho[1] / sum;
}

void geman_mcclure(double s, double c2, double rho[3]) {
  const double sum = c2 + s;
  rho[0] = c2 * s / sum;
  rho[1] = c2 * c2 / (sum * sum);
  rho[2] = -2.0 * rho[1] / sum;
}

/// 2 c^2 (r / c - ln(1 + r / c)) of the norm r.
void fair(double s, double c, double rho[3]) {
  const double r = std::sqrt(s);
  const double sum = c + r;
  rho[0] = 2.0 * c * (r - c * std::log1p(r / c));
  rho[1] = c / sum;
  // The second derivative has a pole at zero; only the first one is needed there.
  rho[2] = r > 0.0 ? -0.5 * c / (r * sum * sum) : 0.0;
}

/// 2 c^2 (sqrt(1 + s / c^2) - 1).
void pseudo_huber(double s, double c2, double rho[3]) {
  const double root = std::sqrt(1.0 + s / c2);
  rho[0] = 2.0 * c2 * (root - 1.0);
  rho[1] = 1.0 / root;
  rho[2] = -0.5 / (c2 * root * root * root);
}

/// Quadratic up to c, constant beyond.
void saturated(double s, double c2, double rho[3]) {
  const bool inside = s <= c2;
  rho[0] = inside ? s : c2;
  rho[1] = inside ? 1.0 : 0.0;
  rho[2] = 0.0;
}

/// Tukey's biweight, c^2 / 3 (1 - (1 - s / c^2)^3) up to c and constant beyond. The class of older
/// versions of Ceres has half of this derivative.
void tukey(double s, double c2, double rho[3]) {
  const double complement = s <= c2 ? 1.0 - s / c2 : 0.0;
  rho[0] = c2 / 3.0 * (1.0 - complement * complement * complement);
  rho[1] = complement * complement;
  rho[2] = -2.0 / c2 * complement;
}

/// c^2 (1 - exp(-s / c^2)).
void welsch(double s, double c2, double rho[3]) {
  const double decay = std::exp(-s / c2);
  rho[0] = c2 * (1.0 - decay);
  rho[1] = decay;
  rho[2] = -decay / c2;
}

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
      return std::make_unique<KernelLoss>(pseudo_huber, size * size);
    case RobustKernel::kFair:
      return std::make_unique<KernelLoss>(fair, size);
    case RobustKernel::kSaturated:
      return std::make_unique<KernelLoss>(saturated, size * size);
    case RobustKernel::kTukey:
      return std::make_unique<KernelLoss>(tukey, size * size);
    case RobustKernel::kWelsch:
      return std::make_unique<KernelLoss>(welsch, size * size);
    case RobustKernel::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(size);
    case RobustKernel::kDcs:
      return std::make_unique<KernelLoss>(dcs, size * size);
    case RobustKernel::kGemanMcClure:
      return std::make_unique<KernelLoss>(geman_mcclure, size * size);
  }
  return nullptr;
}

std::pair<double, double> loss_at(const ceres::LossFunction* loss, double squared_norm) {
  if (loss == nullptr) return {squared_norm, 1.0};
  std::array<double, 3> rho{};
  loss->Evaluate(squared_norm, rho.data());
  return {rho[0], rho[1]};
}

double chi2_limit(int degrees_of_freedom) {
  constexpr std::array<double, 6> kQuantiles = {6.635, 9.210, 11.345, 13.277, 15.086, 16.812};
  if (degrees_of_freedom < 1 || degrees_of_freedom > static_cast<int>(kQuantiles.size())) {
    throw InputError("there is no limit for " + std::to_string(degrees_of_freedom) +
                     " degrees of freedom; a constraint has 1 to 6");
  }
  return kQuantiles[degrees_of_freedom - 1];
}

}  // namespace lidar_mapping::pose_graph
