#include "lidar_mapping/map/cloud_parts.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <unistd.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/map/map_files.hpp"

namespace lidar_mapping::map {

namespace {

namespace fs = std::filesystem;

class PointFile {
 public:
  explicit PointFile(const fs::path& directory) : directory_(directory) {
    fs::create_directories(directory);
    std::string name = (directory / ".points.XXXXXX").string();
    const int descriptor = ::mkstemp(name.data());
    if (descriptor >= 0) ::unlink(name.c_str());
    file_.reset(descriptor >= 0 ? ::fdopen(descriptor, "w+b") : nullptr);
    if (!file_) fail();
  }

  void add(const PointCloud& part) {
    const std::size_t count = part.size();
    if (std::fwrite(part.points.data(), sizeof(Point), count, file_.get()) != count) fail();
    sizes_.push_back(count);
  }

  void each(const CloudParts::Sink& sink) const {
    std::rewind(file_.get());
    PointCloud part;
    for (const std::size_t count : sizes_) {
      part.points.resize(count);
      if (std::fread(part.points.data(), sizeof(Point), count, file_.get()) != count) fail();
      sink(part);
    }
  }

  void finish() {
    if (std::fflush(file_.get()) != 0) fail();
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail() const {
    throw FileError("cannot keep the map's points in " + directory_.string() + ": " +
                    std::strerror(errno) + "; check the free space and the permissions");
  }

  fs::path directory_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<std::size_t> sizes_;
};

}  // namespace

CloudParts stored_parts(const TileSource& tiles, const fs::path& directory) {
  const auto file = std::make_shared<PointFile>(directory);
  tiles([&](const MapTile& tile) { file->add(in_map_frame(tile)); });
  file->finish();
  return CloudParts([file](const CloudParts::Sink& sink) { file->each(sink); });
}

}  // namespace lidar_mapping::map
