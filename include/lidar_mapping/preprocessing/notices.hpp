#pragma once

#include <set>
#include <string>
#include <vector>

namespace lidar_mapping::preprocessing {

/// Sentences for a person, each subject once until it is forgotten.
class Notices {
 public:
  void say(const std::string& subject, const std::string& sentence) {
    if (said_.insert(subject).second) pending_.push_back(sentence);
  }
  /// The next sentence about that subject is news again.
  void forget(const std::string& subject) { said_.erase(subject); }
  std::vector<std::string> take() {
    std::vector<std::string> result;
    result.swap(pending_);
    return result;
  }

 private:
  std::set<std::string> said_;
  std::vector<std::string> pending_;
};

}  // namespace lidar_mapping::preprocessing
