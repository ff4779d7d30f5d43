// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/recorded_odometry.hpp"

#include <utility>

#include "lidar_mapping/front_end/corrected_cloud.hpp"

#include "scans/scan_matching.hpp"
#include "scans/scan_preparation.hpp"
#include "threads/message_list.hpp"
#include "threads/stage_thread.hpp"

namespace lidar_mapping::pipeline {

namespace {

// Lengths of the queues; chosen as in pipeline.cpp.
constexpr std::size_t kInputs = 64;
constexpr std::size_t kScans = 4;

}  // namespace

class RecordedOdometry::Impl {
 public:
  Impl(const PipelineConfig& config, preprocessing::ExtrinsicLookup T_base, Forward forward)
      : threaded_(config.threads != 1),
        forward_(std::move(forward)),
        matching_stage_(
            with_threads(config.front_end, config.threads),
            [this](const preprocessing::SyncedScan& synced, front_end::FrontEndResult&& result) {
              hand_over(synced, std::move(result));
            },
            [this](const std::string& message) { messages_.add(message); }),
        preparation_(
            config.preprocessing, std::move(T_base), pool_,
            [this](PreparedScan&& scan) { matching_.push(std::move(scan)); },
            [this](const std::string& message) { messages_.add(message); }) {}

  void add(Input&& input) { preparing_.push(std::move(input)); }

  void finish() {
    preparing_.finish();
    preparation_.flush();
    matching_.finish();
    matching_stage_.flush();
    forwarding_.finish();
  }

  std::vector<std::string> take_messages() { return messages_.take(); }

 private:
  void match(PreparedScan&& scan) {
    matching_stage_.add(scan.synced);
    pool_.release(std::move(scan.synced.scan.cloud));
  }

  void hand_over(const preprocessing::SyncedScan& synced, front_end::FrontEndResult&& result) {
    OdometryScan scan;
    scan.scan = {synced.scan.stamp,
                 front_end::corrected_cloud(synced.scan.cloud, synced.uneven_turning,
                                            synced.T_base_lidar, result)};
    scan.result = std::move(result);
    scan.p_base_lidar = synced.T_base_lidar.translation;
    forwarding_.push(std::move(scan));
  }

  const bool threaded_;
  const Forward forward_;
  MessageList messages_;
  CloudPool pool_;
  ScanMatching matching_stage_;
  ScanPreparation preparation_;
  // From the last to the first, so that a stage ends before those that it sends to.
  StageThread<OdometryScan> forwarding_{kScans, threaded_,
                                        [this](OdometryScan&& scan) { forward_(std::move(scan)); }};
  StageThread<PreparedScan> matching_{kScans, threaded_,
                                      [this](PreparedScan&& scan) { match(std::move(scan)); }};
  StageThread<Input> preparing_{kInputs, threaded_,
                                [this](Input&& input) { preparation_.add(std::move(input)); }};
};

RecordedOdometry::RecordedOdometry(const PipelineConfig& config,
                                   preprocessing::ExtrinsicLookup T_base, Forward forward)
    : impl_(std::make_unique<Impl>(config, std::move(T_base), std::move(forward))) {}
RecordedOdometry::~RecordedOdometry() = default;

void RecordedOdometry::add(Input input) { impl_->add(std::move(input)); }
void RecordedOdometry::finish() { impl_->finish(); }
std::vector<std::string> RecordedOdometry::take_messages() { return impl_->take_messages(); }

}  // namespace lidar_mapping::pipeline
