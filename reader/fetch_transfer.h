// One file of a store, or a part of it, on its way from a server.
#pragma once

#include <curl/curl.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "palpa/file/protocol.h"

namespace palpa::reader {

/// Transfer of a FetchRequest into a file in memory, with further attempts where the first ones fail. One thread.
class FetchTransfer {
 public:
  using Clock = std::chrono::steady_clock;

  /// \param base  address of the store, without '/' at its end
  FetchTransfer(const std::string& base, const protocol::FetchRequest& request);
  ~FetchTransfer();
  FetchTransfer(const FetchTransfer&) = delete;
  FetchTransfer& operator=(const FetchTransfer&) = delete;

  /// Begins an attempt by a handle, which must outlive it. Throws LoadError if there is no memory for the content.
  void begin(CURL* handle);
  /// Takes the end of an attempt. False: another one is to begin, at `not_before` or later.
  /// \param server_answers    it did so before: faults of the connection are taken for passing ones
  /// \param permits_attempts  after wrong answers
  bool end(CURLcode code, bool server_answers, bool permits_attempts);
  /// Ends with a failure without a further attempt.
  void fail(const std::string& sentence);

  /// [s] since the request came.
  double age_s() const noexcept { return std::chrono::duration<double>(Clock::now() - came_).count(); }
  Clock::time_point not_before() const noexcept { return not_before_; }
  /// [bytes] of memory that it may take.
  std::uint64_t most_bytes() const noexcept;
  /// Whether the last attempt had an answer by HTTP, of any kind.
  bool was_answered() const noexcept { return status_ != 0; }
  const protocol::FetchAnswer& answer() const noexcept { return answer_; }
  int descriptor() const noexcept { return answer_.state == protocol::FetchState::present ? file_ : -1; }

 private:
  struct Range {
    std::uint64_t first = 0, last = 0, whole = 0;  ///< [bytes]
  };
  static std::size_t on_header(char* line, std::size_t one, std::size_t bytes, void* self);
  static std::size_t on_body(char* part, std::size_t one, std::size_t bytes, void* self);
  bool take_header(std::string_view line);
  bool take_body(const char* part, std::size_t bytes);
  void set_options(CURL* handle);
  bool is_part() const noexcept { return request_.bytes > 0; }
  bool finish(CURLcode code);
  void take_content();
  std::string words_of(CURLcode code) const;
  std::string words_of_status() const;
  static std::optional<Range> range_in(std::string_view value);

  std::string base_;
  protocol::FetchRequest request_;
  protocol::FetchAnswer answer_;
  Clock::time_point came_ = Clock::now(), not_before_ = came_;
  CURL* handle_ = nullptr;
  int attempts_ = 0, file_ = -1;
  long status_ = 0;
  std::uint64_t received_ = 0, header_bytes_ = 0;
  std::optional<Range> range_;
  bool is_too_long_ = false, is_encoded_ = false;
  std::array<char, CURL_ERROR_SIZE> problem_{};
};

}  // namespace palpa::reader
