// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/preprocessing/nmea.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {

namespace {

/// Fields of GGA that are used.
enum Field : std::size_t {
  kName = 0,
  kLatitude = 2,
  kNorthOrSouth = 3,
  kLongitude = 4,
  kEastOrWest = 5,
  kQuality = 6,
  kDilution = 8,
  kAltitude = 9,
  kGeoid = 11,
  kFields = 12
};

/// Meaning of the sentence's quality: the status in sensor_msgs/NavSatFix, and the error (m) that
/// is multiplied by the dilution. Receivers do not report this error; these are the usual values of
/// a driver.
struct Quality {
  int status;
  double sigma;
};

std::optional<Quality> quality_of(const std::string& field) {
  if (field.size() != 1) return std::nullopt;
  switch (field[0]) {
    case '1':  // autonomous
    case '3':  // precise positioning service
      return Quality{0, 4.0};
    case '2':  // differential, or satellite-based correction
      return Quality{1, 1.0};
    case '4':  // RTK, fixed
      return Quality{2, 0.02};
    case '5':  // RTK, float
      return Quality{2, 0.5};
    default:  // none, estimated, typed in or simulated
      return std::nullopt;
  }
}

// Chosen: receivers send some kinds of sentences, each once or more in a second, so a GGA would
// have come several times.
constexpr std::size_t kEnoughSentences = 50;

std::vector<std::string> fields_of(const std::string& text) {
  std::istringstream stream(text + ',');  // else an empty field at the end would be lost
  std::vector<std::string> fields;
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

/// The text between '$' and '*'; empty if the checksum after it does not agree.
std::optional<std::string> body_of(const std::string& sentence) {
  const std::size_t begin = sentence.find('$');
  if (begin == std::string::npos) return std::nullopt;
  const std::size_t end = sentence.find_first_of("*\r\n", begin);
  const std::string body =
      sentence.substr(begin + 1, end == std::string::npos ? std::string::npos : end - begin - 1);
  if (end == std::string::npos || sentence[end] != '*') return body;
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  if (lower_case(sentence.substr(end + 1, 2)) != formatted("%02x", sum)) return std::nullopt;
  return body;
}

std::optional<double> number(const std::string& field) {
  if (field.empty()) return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(field.c_str(), &end);
  if (end != field.c_str() + field.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// "4807.038" and "N" as degrees: the last two digits before the point and what follows are
/// minutes.
std::optional<double> degrees(const std::string& field, const std::string& side, char positive,
                              char negative, double most) {
  const auto value = number(field);
  if (!value || *value < 0.0 || side.size() != 1) return std::nullopt;
  if (side[0] != positive && side[0] != negative) return std::nullopt;
  const double whole = std::floor(*value / 100.0);
  const double minutes = *value - 100.0 * whole;
  const double angle = whole + minutes / 60.0;
  if (minutes >= 60.0 || angle > most) return std::nullopt;
  return side[0] == positive ? angle : -angle;
}

Eigen::Matrix3d covariance_of(double dilution, double sigma) {
  const double horizontal = dilution * sigma;
  return Eigen::Vector3d(horizontal, horizontal, 2.0 * horizontal).cwiseAbs2().asDiagonal();
}

}  // namespace

std::optional<GnssFix> fix_of_nmea(const std::string& sentence, Stamp stamp) {
  const auto body = body_of(sentence);
  if (!body) return std::nullopt;
  const std::vector<std::string> fields = fields_of(*body);
  if (fields.size() < kFields) return std::nullopt;
  if (fields[kName].size() != 5 || fields[kName].substr(2) != "GGA") return std::nullopt;
  const auto quality = quality_of(fields[kQuality]);
  const auto latitude = degrees(fields[kLatitude], fields[kNorthOrSouth], 'N', 'S', 90.0);
  const auto longitude = degrees(fields[kLongitude], fields[kEastOrWest], 'E', 'W', 180.0);
  // A receiver with a position in the plane only leaves the altitude empty.
  const auto altitude =
      fields[kAltitude].empty() ? std::optional<double>(std::nan("")) : number(fields[kAltitude]);
  if (!quality || !latitude || !longitude || !altitude) return std::nullopt;
  GnssFix fix;
  fix.stamp = stamp;
  fix.latitude_deg = *latitude;
  fix.longitude_deg = *longitude;
  fix.altitude_m = *altitude + number(fields[kGeoid]).value_or(0.0);
  if (std::isinf(fix.altitude_m)) return std::nullopt;
  fix.status = quality->status;
  const auto dilution = number(fields[kDilution]);
  if (dilution && *dilution > 0.0) fix.covariance = covariance_of(*dilution, quality->sigma);
  return fix;
}

std::string SentenceCheck::add(const std::string& sentence) {
  const std::size_t begin = sentence.find('$');
  const std::size_t kind = begin == std::string::npos ? begin : begin + 3;
  if (kind < sentence.size() && sentence.compare(kind, 4, "GGA,") == 0) has_gga_ = true;
  if (has_gga_ || ++count_ != kEnoughSentences) return "";
  return "no GGA among the first " + std::to_string(kEnoughSentences) +
         " sentences of the receiver: positions are read from GGA alone, RMC has no quality; let "
         "it send GGA, too";
}

}  // namespace lidar_mapping::preprocessing
