// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/drive.hpp"

#include <algorithm>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/simulation/random.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

#include "scenarios/scenario.hpp"
#include "sensors/samples.hpp"
#include "sensors/scanner.hpp"

namespace lidar_mapping::simulation {

namespace {

/// Independent streams of noise.
enum Stream : std::uint64_t {
  kScanNoise = 0x100,
  kImuNoise,
  kVelocityNoise,
  kGnssNoise,
  kScanFaults,
  kImuFaults
};

/// Time after which every sensor has delivered samples; the first scan begins then, ns.
constexpr Stamp kFirstScanAfter = 200'000'000;

constexpr Stamp kDay = 86'400'000'000'000;  ///< ns

constexpr double kMinDuration = 1.0;  ///< s; chosen: ten scans

// Chosen: longer than any drive, and a hundred years. Stamps in ns of much more would overflow.
constexpr double kMaxStart = 1e6;  ///< s
constexpr std::uint64_t kMaxPass = 36'500;

struct NamedDrive {
  const char* name;
  Scenario (*make)(const DriveOptions&);
  bool has_reverse = false;      ///< DriveOptions::reverse has a meaning.
  bool has_parked_cars = false;  ///< DriveOptions::parked has a meaning.
};
constexpr NamedDrive kDrives[] = {{"town", make_town, true, true},
                                  {"figure_eight", make_figure_eight, true, true},
                                  {"open_road", make_open_road, true},
                                  {"tunnel", make_tunnel},
                                  {"car_park", make_car_park, true, true},
                                  {"walk", make_walk},
                                  {"twins", make_twins, true, true},
                                  {"city", make_city, true, true},
                                  {"handheld", make_handheld},
                                  {"handheld_forest", make_handheld_forest},
                                  {"running", make_running},
                                  {"running_forest", make_running_forest},
                                  {"spin", make_spin},
                                  {"stairs", make_stairs},
                                  {"legged", make_legged},
                                  {"legged_forest", make_legged_forest},
                                  {"drone", make_drone},
                                  {"elevator", make_elevator}};

void require(bool holds, const std::string& message) {
  if (!holds) throw ConfigError("simulation: " + message);
}

/// Throws ConfigError if an option has no meaning for the drive.
void check_meaning(const NamedDrive& drive, const DriveOptions& options) {
  const auto refuse = [&](const std::string& option, bool NamedDrive::*has_option) {
    std::string names;
    for (const NamedDrive& other : kDrives) {
      if (other.*has_option) names += std::string(" ") + other.name;
    }
    throw ConfigError("simulation: " + option + " has no meaning for the drive '" + drive.name +
                      "', only for" + names);
  };
  if (options.reverse && !drive.has_reverse) refuse("reverse", &NamedDrive::has_reverse);
  if (options.parked != 0 && !drive.has_parked_cars) {
    refuse("parked", &NamedDrive::has_parked_cars);
  }
}

Scenario make_scenario(const DriveOptions& options) {
  require(
      options.scan_rate >= 1.0 && options.scan_rate <= 50.0,
      "scan_rate " + std::to_string(options.scan_rate) + " is outside 1 to 50 turns per second");
  require(!options.duration || *options.duration >= kMinDuration,
          "duration is shorter than 1 s; ask for more");
  require(options.start >= 0.0 && options.start <= kMaxStart,
          "start " + std::to_string(options.start) + " is outside 0 to 1000000 seconds");
  require(options.pass <= kMaxPass,
          "pass " + std::to_string(options.pass) + " is not one of 0 to 36500");
  require(options.rounds >= 1, "rounds " + std::to_string(options.rounds) + "; use 1 or more");
  require(options.range_noise >= 0.0, "range_noise is negative; use 0 or more metres");
  require(
      options.gnss_rate >= 0.1 && options.gnss_rate <= 100.0,
      "gnss_rate " + std::to_string(options.gnss_rate) + " is outside 0.1 to 100 fixes per second");
  require(options.gnss_noise > 0.0, "gnss_noise must be greater than 0 metres");
  for (const NamedDrive& drive : kDrives) {
    if (options.drive != drive.name) continue;
    check_meaning(drive, options);
    return drive.make(options);
  }
  throw ConfigError("drive: '" + options.drive + "' is unknown; use one of " +
                    joined(drive_names(), " "));
}

}  // namespace

class Drive::Impl {
 public:
  /// `T_base_lidar`: its place, if it is not that of the scenario. `phase`: of its turns, ns.
  explicit Impl(const DriveOptions& options, const Pose* T_base_lidar = nullptr, Stamp phase = 0)
      : options_(options),
        phase_(phase),
        lidar_(lidar_model(options.lidar)),
        imu_(imu_model(options.imu)),
        scenario_(make_scenario(options)),
        caster_(scenario_.world),
        period_(from_seconds(1.0 / options.scan_rate)),
        faults_(options.scan_faults, noise_seed(kScanFaults)) {
    scenario_.trajectory.delay(static_cast<Stamp>(options.pass) * kDay);
    if (T_base_lidar != nullptr) scenario_.mounting.T_base_lidar = *T_base_lidar;
    end_ = scenario_.trajectory.end();
    // Compared in seconds: a duration may be longer than a stamp can hold.
    if (options.duration && *options.duration < to_seconds(end_ - scenario_.trajectory.begin())) {
      end_ = scenario_.trajectory.begin() + from_seconds(*options.duration);
    }
    require(to_seconds(end_ - begin()) >= kMinDuration,
            "start " + std::to_string(options.start) +
                " s leaves less than 1 s of a drive that ends at " +
                std::to_string(to_seconds(end_ - scenario_.trajectory.begin())) +
                " s; start earlier");
    const Stamp free = end_ - scan_stamp(0);
    scan_count_ = free < 0 ? 0 : static_cast<std::size_t>(free / period_);
    outages_ = scenario_.covered;
    outages_.insert(outages_.end(), options.gnss_outages.begin(), options.gnss_outages.end());
  }

  /// Beginning of the drive after the cut.
  Stamp begin() const { return scenario_.trajectory.begin() + from_seconds(options_.start); }

  Stamp scan_stamp(std::size_t index) const {
    return begin() + kFirstScanAfter + phase_ + static_cast<Stamp>(index) * period_;
  }

  SimulatedScan scan(std::size_t index) const {
    require(index < scan_count_, "scan " + std::to_string(index) + " is not one of the drive's " +
                                     std::to_string(scan_count_));
    const std::size_t source = faults_.source(index, period_);
    SimulatedScan scan = take_scan({caster_, scenario_.trajectory, lidar_,
                                    scenario_.mounting.T_base_lidar, source, scan_stamp(source),
                                    period_, options_.undistorted, scenario_.near_objects_occlude,
                                    options_.range_noise, noise_seed(kScanNoise) ^ mix64(source)});
    faults_.corrupt(scan, source, lidar_, options_.range_noise);
    scan.stamp = reported_stamp(index);
    scan.end = scan_stamp(index) + period_;
    return scan;
  }

  Stamp reported_stamp(std::size_t index) const {
    return scan_stamp(index) + faults_.stamp_error(index, period_);
  }

  std::uint64_t noise_seed(Stream stream) const {
    return mix64(day_seed(options_, options_.seed) ^ mix64(stream));
  }

  /// Removes the samples outside of a cut drive.
  template <typename Sample>
  std::vector<Sample> cut(std::vector<Sample> samples) const {
    const auto is_outside = [this](const Sample& sample) {
      return sample.stamp < begin() || sample.stamp > end_;
    };
    samples.erase(std::remove_if(samples.begin(), samples.end(), is_outside), samples.end());
    return samples;
  }

  DriveOptions options_;
  Stamp phase_;
  LidarModel lidar_;
  ImuModel imu_;
  Scenario scenario_;
  RayCaster caster_;
  Stamp period_;
  ScanFaults faults_;
  Stamp end_ = 0;
  std::size_t scan_count_ = 0;
  std::vector<GnssOutage> outages_;
};

Drive::Drive(const DriveOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Drive::Drive(const DriveOptions& options, const Pose& T_base_lidar, Stamp phase)
    : impl_(std::make_unique<Impl>(options, &T_base_lidar, phase)) {}
Drive::~Drive() = default;
Drive::Drive(Drive&&) noexcept = default;
Drive& Drive::operator=(Drive&&) noexcept = default;

Drive Drive::with_lidar(const std::string& lidar, const Pose& T_base_lidar, Stamp phase) const {
  DriveOptions options = impl_->options_;
  options.lidar = lidar;
  return {options, T_base_lidar, phase};
}

const SmoothTrajectory& Drive::trajectory() const { return impl_->scenario_.trajectory; }
const World& Drive::world() const { return impl_->scenario_.world; }
const SensorMounting& Drive::mounting() const { return impl_->scenario_.mounting; }
const LidarModel& Drive::lidar() const { return impl_->lidar_; }
GeodeticDatum Drive::datum() const { return kDatum; }
std::size_t Drive::scan_count() const { return impl_->scan_count_; }
Stamp Drive::scan_stamp(std::size_t index) const { return impl_->scan_stamp(index); }
Stamp Drive::reported_stamp(std::size_t index) const { return impl_->reported_stamp(index); }
SimulatedScan Drive::scan(std::size_t index) const { return impl_->scan(index); }

Scan Drive::base_scan(std::size_t index) const {
  const SimulatedScan scan = impl_->scan(index);
  return {scan.stamp, transformed(scan.cloud, mounting().T_base_lidar)};
}

std::vector<ImuSample> Drive::imu() const {
  std::vector<ImuSample> samples =
      sample_imu(trajectory(), mounting().T_base_imu, impl_->imu_, impl_->scenario_.imu_period,
                 impl_->noise_seed(kImuNoise));
  corrupt(samples, impl_->options_.imu_faults, trajectory().begin(), impl_->noise_seed(kImuFaults));
  return impl_->cut(std::move(samples));
}

std::vector<VelocitySample> Drive::velocity() const {
  return impl_->cut(
      sample_velocity(trajectory(), mounting().T_base_imu, impl_->noise_seed(kVelocityNoise)));
}

std::vector<GnssFix> Drive::gnss() const {
  return impl_->cut(sample_gnss(trajectory(), mounting().p_base_antenna, impl_->options_.gnss_rate,
                                impl_->options_.gnss_noise, impl_->outages_,
                                impl_->options_.gnss_jumps, impl_->noise_seed(kGnssNoise)));
}

void add_fault(DriveOptions& options, const std::string& text) {
  if (text.rfind("imu_", 0) == 0) {
    options.imu_faults.push_back(parse_imu_fault(text));
  } else {
    options.scan_faults.push_back(parse_scan_fault(text));
  }
}

std::vector<std::string> drive_names() {
  std::vector<std::string> names;
  for (const NamedDrive& drive : kDrives) names.emplace_back(drive.name);
  return names;
}

}  // namespace lidar_mapping::simulation
