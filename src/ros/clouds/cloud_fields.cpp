// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_fields.hpp"

namespace lidar_mapping::ros_border {

void set_layout(sensor_msgs::PointCloud2& message, const std::vector<FieldLayout>& fields,
                std::uint32_t point_step, std::uint32_t count) {
  message.fields.clear();
  for (const FieldLayout& layout : fields) {
    sensor_msgs::PointField field;
    field.name = layout.name;
    field.datatype = layout.datatype;
    field.offset = layout.offset;
    field.count = 1;
    message.fields.push_back(field);
  }
  message.height = 1;
  message.width = count;
  message.point_step = point_step;
  message.row_step = point_step * count;
}

}  // namespace lidar_mapping::ros_border
