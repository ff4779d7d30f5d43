// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/map/write_products.hpp"

#include "lidar_mapping/common/errors.hpp"

#include "map_formats.hpp"
#include "product_writer.hpp"

namespace lidar_mapping::map {

Products write_products(const KeyFramePoses& poses, CloudSource& clouds, const MapConfig& config,
                        const ProductOptions& requested_options,
                        const std::filesystem::path& directory) {
  ProductOptions options = requested_options;
  options.formats = known_formats(requested_options.formats, config);
  if (options.utm && !options.datum) {
    throw InputError(
        "the place of the map on Earth is not known, as there was no GNSS; leave UTM out");
  }
  return ProductWriter(poses, clouds, config, options, directory).write();
}

}  // namespace lidar_mapping::map
