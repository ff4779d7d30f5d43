// SPDX-License-Identifier: BSD-3-Clause
#include "campaign_case.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"

namespace lidar_mapping::campaign {

namespace {

constexpr double kMaxSeed = 9e15;     // below 2^53, so that a double holds it by its format
constexpr double kMaxDuration = 1e6;  // s; chosen: eleven days, more is a mistake

/// The value of a key, within what the simulation can do.
double number_of(const std::string& key, const std::string& text, double least, double most) {
  std::istringstream stream(text);
  double value = 0.0;
  if (!(stream >> value) || !stream.eof()) {
    throw ConfigError("case: " + key + "=" + text + " is not a number");
  }
  if (value >= least && value <= most) return value;
  std::ostringstream range;
  range << "; use " << least << " to " << most;
  throw ConfigError("case: " + key + "=" + text + range.str());
}

/// The same of a whole number.
std::uint64_t whole_number_of(const std::string& key, const std::string& text, double least,
                              double most) {
  const double value = number_of(key, text, least, most);
  if (value == std::floor(value)) return static_cast<std::uint64_t>(value);
  throw ConfigError("case: " + key + "=" + text + " is not a whole number");
}

/// Shortest text of a number of few digits.
std::string text_of(double value) {
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

void check_imu(const std::string& value) {
  std::vector<std::string> names = simulation::imu_names();
  names.insert(names.begin(), "none");
  if (contains(names, value)) return;
  throw ConfigError("case: imu=" + value + "; use one of " + joined(names, " "));
}

void set(CampaignCase& result, const std::string& key, const std::string& value) {
  if (key == "drive") {
    result.drive = value;
  } else if (key == "lidar") {
    result.lidar = value;
  } else if (key == "seed") {
    result.seed = whole_number_of(key, value, 0.0, kMaxSeed);
  } else if (key == "start") {
    result.start = number_of(key, value, 0.0, kMaxDuration);
  } else if (key == "scan_rate") {
    result.scan_rate = number_of(key, value, 1.0, 50.0);
  } else if (key == "range_noise") {
    result.range_noise = number_of(key, value, 0.0, 10.0);
  } else if (key == "every") {
    result.every = whole_number_of(key, value, 1.0, 1000.0);
  } else if (key == "undistorted") {
    result.undistorted = whole_number_of(key, value, 0.0, 1.0) == 1;
  } else if (key == "method") {
    result.method = value;
  } else if (key == "fault") {
    simulation::DriveOptions checked;
    simulation::add_fault(checked, value);
    result.faults.push_back(value);
  } else if (key == "imu") {
    check_imu(value);
    result.imu = value;
  } else {
    throw ConfigError("case: '" + key +
                      "' is unknown; use drive, lidar, seed, start, scan_rate, range_noise, every, "
                      "undistorted, method, imu or fault");
  }
}

template <typename T>
const T& one_of(const std::vector<T>& values, simulation::Random& random) {
  return values[random.integer(0, static_cast<int>(values.size()) - 1)];
}

std::string random_fault(simulation::Random& random) {
  const auto fraction = [&](double most) {
    return "=" + text_of(std::round(100.0 * random.uniform(0.01, most)) / 100.0);
  };
  switch (random.integer(0, 6)) {
    case 0:
      return "outliers" + fraction(0.35);
    case 1:
      return "rain" + fraction(0.35);
    case 2:
      return "wall";
    case 3:
      return "jitter" + fraction(0.03);
    case 4:
      return "frozen=" + std::to_string(random.integer(1, 15)) + ",8";
    case 5:
      return random.chance(0.5) ? "times=none" : "times=negated";
    default:
      return "sparse=" + std::to_string(random.integer(3, 40) * 100);
  }
}

std::string random_imu_fault(simulation::Random& random) {
  const auto number = [&](double low, double high) {
    return text_of(std::round(1000.0 * random.uniform(low, high)) / 1000.0);
  };
  switch (random.integer(0, 7)) {
    case 0:
      return "imu_vibration=" + number(0.5, 20.0);
    case 1:
      return "imu_scale=" + number(-0.2, 0.2);
    case 2:
      return "imu_axis=" +
             one_of(std::vector<std::string>{"gx", "gy", "gz", "ax", "ay", "az"}, random);
    case 3:
      return "imu_clip=" + number(1.2, 4.0) + "," + number(1.0, 8.0);
    case 4:
      return "imu_frame";
    case 5:
      return random.chance(0.5) ? "imu_units=g" : "imu_units=degrees";
    case 6:
      return "imu_offset=" + number(-0.1, 0.1);
    default:
      return "imu_gap=" + number(0.1, 3.0) + ",8";
  }
}

}  // namespace

CampaignCase parse_case(const std::string& line) {
  std::istringstream words(line);
  CampaignCase result;
  if (!(words >> result.name)) throw ConfigError("case: the line is empty; begin with a name");
  if (result.name.find('=') != std::string::npos) {
    throw ConfigError("case: the line begins with " + result.name +
                      "; begin with a name, which has no '='");
  }
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) {
      throw ConfigError("case: '" + word + "' is not of the form key=value");
    }
    set(result, word.substr(0, equals), word.substr(equals + 1));
  }
  return result;
}

simulation::DriveOptions drive_options(const CampaignCase& c, double duration) {
  simulation::DriveOptions options;
  options.drive = c.drive;
  options.lidar = c.lidar;
  options.seed = c.seed.value_or(1);
  options.start = c.start;
  options.duration = c.start + duration;
  options.scan_rate = c.scan_rate;
  options.range_noise = c.range_noise;
  options.undistorted = c.undistorted;
  if (c.imu != "none") options.imu = c.imu;
  for (const std::string& fault : c.faults) simulation::add_fault(options, fault);
  return options;
}

std::string to_line(const CampaignCase& c) {
  const CampaignCase usual;
  std::string line = c.name;
  if (c.drive != usual.drive) line += " drive=" + c.drive;
  if (!c.lidar.empty()) line += " lidar=" + c.lidar;
  if (c.seed) line += " seed=" + std::to_string(*c.seed);
  if (c.start != usual.start) line += " start=" + text_of(c.start);
  if (c.scan_rate != usual.scan_rate) line += " scan_rate=" + text_of(c.scan_rate);
  if (c.range_noise != usual.range_noise) line += " range_noise=" + text_of(c.range_noise);
  if (c.every != usual.every) line += " every=" + std::to_string(c.every);
  if (c.undistorted) line += " undistorted=1";
  if (c.method != usual.method) line += " method=" + c.method;
  if (c.imu != usual.imu) line += " imu=" + c.imu;
  for (const std::string& fault : c.faults) line += " fault=" + fault;
  return line;
}

std::vector<CampaignCase> read_cases(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw FileError("cannot read " + path);
  std::vector<CampaignCase> cases;
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    try {
      cases.push_back(parse_case(line));
    } catch (const ConfigError& error) {
      throw ConfigError(path + ", line " + std::to_string(number) + ": " + error.what());
    }
  }
  if (cases.empty()) throw ConfigError(path + " has no cases; write 'NAME key=value ...' a line");
  return cases;
}

std::vector<CampaignCase> usual_cases() {
  std::vector<CampaignCase> cases;
  for (const char* line :
       {"clean", "outliers_5 fault=outliers=0.05", "outliers_15 fault=outliers=0.15",
        "outliers_30 fault=outliers=0.3", "rain_15 fault=rain=0.15", "rain_30 fault=rain=0.3",
        "wall fault=wall", "sparse_500 fault=sparse=500", "sparse_2000 fault=sparse=2000",
        "frozen_1 fault=frozen=1,5", "frozen_3 fault=frozen=3,5", "frozen_10 fault=frozen=10,5",
        "jitter_20ms fault=jitter=0.02", "every_4th every=4"}) {
    cases.push_back(parse_case(line));
  }
  return cases;
}

CampaignCase random_case(simulation::Random& random) {
  CampaignCase result;
  result.name = "random";
  result.drive = one_of(simulation::drive_names(), random);
  result.lidar = one_of(simulation::lidar_names(), random);
  result.seed = static_cast<std::uint64_t>(random.integer(1000, 999999));
  result.start = random.integer(0, 20);
  result.scan_rate = random.chance(0.8) ? 10.0 : 5.0;
  result.range_noise = random.chance(0.8) ? 0.02 : 0.04;
  result.every = random.chance(0.85) ? 1 : static_cast<std::size_t>(random.integer(2, 4));
  result.undistorted = random.chance(0.2);
  const int faults = random.integer(0, 2);
  for (int i = 0; i < faults; ++i) result.faults.push_back(random_fault(random));
  if (random.chance(0.5)) return result;
  result.imu = random.chance(0.5) ? "consumer" : "good";
  if (random.chance(0.4)) result.faults.push_back(random_imu_fault(random));
  return result;
}

}  // namespace lidar_mapping::campaign
