#include "palpa/file/late_checksums.h"

#include <chrono>
#include <future>
#include <utility>

#include "palpa/base/load_error.h"
#include "palpa/data/sha256.h"

namespace palpa::detail {

namespace {

class ChecksumsOfThread final : public LateChecksums {
 public:
  ChecksumsOfThread(std::function<std::vector<std::string>()> compute, std::stop_source stop)
      : stop_(std::move(stop)), texts_(std::async(std::launch::async, [compute = std::move(compute)] {
          try {
            return compute();
          } catch (const LoadError&) {  // a file that is gone: its recordings are not felt again
            return std::vector<std::string>{};
          }
        })) {}
  ~ChecksumsOfThread() override { stop_.request_stop(); }
  ChecksumsOfThread(const ChecksumsOfThread&) = delete;
  ChecksumsOfThread& operator=(const ChecksumsOfThread&) = delete;

  bool are_known() const override { return texts_.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }
  std::string text(std::size_t file) const override {
    const std::vector<std::string>& texts = texts_.get();
    return file < texts.size() ? texts[file] : std::string();
  }

 private:
  std::stop_source stop_;
  std::shared_future<std::vector<std::string>> texts_;  // its destructor waits for the thread
};

}  // namespace

std::shared_ptr<const LateChecksums> checksums_by(std::function<std::vector<std::string>()> compute, std::stop_source stop) {
  return std::make_shared<const ChecksumsOfThread>(std::move(compute), std::move(stop));
}

Checksum checksum_by_thread(const std::string& path, std::stop_source stop) {
  const auto compute = [path, ends = stop.get_token()] { return std::vector{sha256_of_file(path, ends)}; };
  return {checksums_by(compute, std::move(stop)), 0};
}

}  // namespace palpa::detail
