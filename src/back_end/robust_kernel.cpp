#include "lidar_mapping/back_end/robust_kernel.hpp"

#include <algorithm>
#include <array>

namespace lidar_mapping::back_end {

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

}  // namespace

const std::vector<std::pair<std::string, RobustKernel>>& robust_kernel_names() {
  static const std::vector<std::pair<std::string, RobustKernel>> names = {
      {"none", RobustKernel::kNone},
      {"Huber", RobustKernel::kHuber},
      {"Cauchy", RobustKernel::kCauchy},
      {"DCS", RobustKernel::kDcs},
      {"GemanMcClure", RobustKernel::kGemanMcClure}};
  return names;
}

std::unique_ptr<ceres::LossFunction> make_kernel(RobustKernel kernel, double size) {
  switch (kernel) {
    case RobustKernel::kNone:
      return nullptr;
    case RobustKernel::kHuber:
      return std::make_unique<ceres::HuberLoss>(size);
    case RobustKernel::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(size);
    case RobustKernel::kDcs:
      return std::make_unique<DcsLoss>(size * size);
    case RobustKernel::kGemanMcClure:
      return std::make_unique<GemanMcClureLoss>(size * size);
  }
  return nullptr;
}

double contradiction_limit(int degrees_of_freedom) {
  constexpr std::array<double, 6> kQuantiles = {6.635, 9.210, 11.345, 13.277, 15.086, 16.812};
  return kQuantiles[static_cast<std::size_t>(std::clamp(degrees_of_freedom, 1, 6) - 1)];
}

}  // namespace lidar_mapping::back_end
