// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/session/pcd_points.hpp"

#include <fstream>
#include <vector>

#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::session {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_unreadable(const fs::path& path, const std::string& problem) {
  throw FileError("cannot read " + path.string() + ": its points cannot be read" + problem +
                  "; it is a damaged PCD file");
}

pcl::PCLPointCloud2 layout_of(const PcdHeader& header) {
  pcl::PCLPointCloud2 cloud;
  cloud.width = static_cast<pcl::uindex_t>(header.width);
  cloud.height = static_cast<pcl::uindex_t>(header.points / header.width);
  cloud.point_step = static_cast<pcl::uindex_t>(header.step());
  cloud.row_step = cloud.point_step * cloud.width;
  pcl::uindex_t offset = 0;
  for (const PcdField& from : header.fields) {
    pcl::PCLPointField field;
    field.name = from.name;
    field.offset = offset;
    field.datatype =
        static_cast<std::uint8_t>(pcl::getFieldType(static_cast<int>(from.size), from.type));
    field.count = static_cast<pcl::uindex_t>(from.count);
    offset += static_cast<pcl::uindex_t>(from.size * from.count);
    cloud.fields.push_back(field);
  }
  cloud.data.resize(header.points * header.step());
  return cloud;
}

void read_bytes(std::istream& file, const fs::path& path, void* to, std::size_t size) {
  file.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
  if (!file) throw_unreadable(path, ": the end is missing");
}

int read_compressed(std::istream& file, const fs::path& path, std::size_t size,
                    pcl::PCLPointCloud2& cloud) {
  std::vector<unsigned char> bytes(size);
  read_bytes(file, path, bytes.data(), size);
  return pcl::PCDReader().readBodyBinary(bytes.data(), cloud, pcl::PCDReader::PCD_V7, true, 0);
}

int read_body(std::istream& file, const fs::path& path, const PcdHeader& header,
              pcl::PCLPointCloud2& cloud) {
  if (header.data == "ascii") {
    return pcl::PCDReader().readBodyASCII(file, cloud, pcl::PCDReader::PCD_V7);
  }
  if (header.data == "binary_compressed") {
    return read_compressed(file, path, fs::file_size(path) - header.text.size(), cloud);
  }
  read_bytes(file, path, cloud.data.data(), cloud.data.size());
  return 0;
}

}  // namespace

pcl::PCLPointCloud2 read_pcd_points(const fs::path& path, const PcdHeader& header) {
  if (header.points == 0) return {};
  pcl::PCLPointCloud2 cloud = layout_of(header);
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(header.text.size()));
  int status = -1;
  std::string problem;
  try {
    status = read_body(file, path, header, cloud);
  } catch (const FileError&) {
    throw;
    // Thrown by PCL, such as std::out_of_range for a short line.
  } catch (const std::exception& error) {
    problem = std::string(" (") + error.what() + ")";
  }
  if (status < 0) throw_unreadable(path, problem);
  return cloud;
}

}  // namespace lidar_mapping::session
