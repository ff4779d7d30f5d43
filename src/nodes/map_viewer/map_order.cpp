// SPDX-License-Identifier: BSD-3-Clause
#include "map_viewer/map_order.hpp"

#include <vector>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

namespace {

namespace fs = std::filesystem;

/// Format of a map file by its extension, in lower case.
std::string format_of(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  std::vector<std::string> known;
  for (const std::string& name : map::single_file_formats()) {
    if (extension == "." + name) return name;
    known.push_back("." + name);
  }
  throw InputError("destination is '" + file.string() + "', which does not end in " +
                   joined(known) + ": it is the name of one file");
}

void name_file(const SaveMap::Request& request, MapOrder& order) {
  if (!request.directory.empty() || !request.formats.empty()) {
    throw InputError("destination names one file; leave directory and formats empty");
  }
  const fs::path file = fs::absolute(expanded_path(request.destination)).lexically_normal();
  const std::string format = format_of(file);
  order.directory = file.parent_path();
  order.options.name = file.stem().string();
  order.options.formats = {format};
  // The extension is written in lower case, whatever was requested.
  order.destination = order.directory / (order.options.name + "." + format);
  for (const fs::path& other : {order.destination, fs::path(order.destination.string() + ".utm"),
                                order.directory / (order.options.name + ".yaml")}) {
    if (!fs::exists(other)) continue;
    throw FileError(other.string() + " is there already; name another file");
  }
}

}  // namespace

MapOrder map_order(const SaveMap::Request& request) {
  MapOrder order;
  order.options.keep_moving = request.keep_moving;
  order.options.utm = request.utm;
  order.options.crop = map::crop_box(request.crop);
  if (!request.destination.empty()) {
    name_file(request, order);
    return order;
  }
  if (!request.formats.empty()) order.options.formats = request.formats;
  if (!request.directory.empty()) order.directory = expanded_path(request.directory);
  return order;
}

}  // namespace lidar_mapping::ros_border
