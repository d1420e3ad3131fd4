#include "fetch_transfer.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <utility>

#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/file/store_protocol.h"
#include "palpa/version.h"

namespace palpa::reader {
namespace {

using namespace std::chrono_literals;

// [ms, s, bytes/s] Of an attempt. Longer, less: a dead server holds windows up; shorter, more: slow ones lose chunks.
constexpr long connecting_ms = 4000, stalled_s = 4, stalled_bytes_per_s = 500;
// Faults that pass: an attempt begins up to this age of the request, after a pause that doubles. More: windows come late; less:
// a server that starts anew has lost chunks.
constexpr double latest_attempt_s = 6.0;
constexpr int most_attempts = 7, most_answered_attempts = 3;
constexpr auto first_pause = 100ms;
// [bytes] More of either: a hostile server takes more; less: the answers of usual ones are refused.
constexpr std::uint64_t most_header_bytes = 64 << 10, most_error_bytes = 64 << 10;

/// Whether a fault of the connection may pass.
bool may_pass(CURLcode code) noexcept {
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_CONNECT:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_PARTIAL_FILE:
    case CURLE_SSL_CONNECT_ERROR: return true;
    default: return false;
  }
}

bool may_pass(long status) noexcept {
  return status == 429 || status == 500 || status == 502 || status == 503 || status == 504;
}

/// Path of a plain name in an address: letters, digits and "_-.~/" as they are.
std::string in_address(const std::string& name) {
  std::string text;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain = std::isalnum(byte) != 0 || c == '_' || c == '-' || c == '.' || c == '~' || c == '/';
    text += is_plain ? std::string(1, c) : detail::text("%%%02X", static_cast<unsigned>(byte));
  }
  return text;
}

/// The value of a header line of this name, without blanks about it; none of other lines.
std::optional<std::string_view> value_in(std::string_view line, std::string_view name) {
  if (line.size() <= name.size() || line[name.size()] != ':') return std::nullopt;
  for (std::size_t n = 0; n < name.size(); ++n) {
    if (std::tolower(static_cast<unsigned char>(line[n])) != name[n]) return std::nullopt;
  }
  line.remove_prefix(name.size() + 1);
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t first = line.find_first_not_of(blanks), last = line.find_last_not_of(blanks);
  return first == line.npos ? std::string_view() : line.substr(first, last - first + 1);
}

/// Number at the begin of a text, which is taken away.
std::optional<std::uint64_t> number_of(std::string_view& text) {
  std::uint64_t number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc() || number > INT64_MAX) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

bool take(std::string_view& text, std::string_view mark) {
  if (!text.starts_with(mark)) return false;
  text.remove_prefix(mark.size());
  return true;
}

template <class Value>
void set(CURL* handle, CURLoption option, Value value) {
  if (::curl_easy_setopt(handle, option, value) != CURLE_OK)
    throw LoadError("cannot be fetched: libcurl has not all that palpa-fetch needs; update it");
}

}  // namespace

FetchTransfer::FetchTransfer(const std::string& base, const protocol::FetchRequest& request) : base_(base), request_(request) {
  answer_.number = request.number;
}

FetchTransfer::~FetchTransfer() {
  if (file_ >= 0) ::close(file_);
}

std::uint64_t FetchTransfer::most_bytes() const noexcept {
  return std::max(std::min<std::uint64_t>(request_.most_bytes, protocol::most_whole_file_bytes), request_.bytes);
}

void FetchTransfer::set_options(CURL* handle) {
  const std::string address = base_ + "/" + in_address(request_.name);
  const std::string agent = std::string("palpa/") + version;
  const std::string first = std::to_string(request_.first), last = std::to_string(request_.first + request_.bytes - 1);
  const std::string range = request_.from_end ? "-" + std::to_string(request_.bytes) : first + "-" + last;
  const double left_s = std::max(protocol::longest_fetch_s - age_s(), 1.0);
  ::curl_easy_reset(handle);  // keeps connections
  set(handle, CURLOPT_URL, address.c_str());
  set(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  set(handle, CURLOPT_FOLLOWLOCATION, 0L);
  set(handle, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  set(handle, CURLOPT_PATH_AS_IS, 1L);
  set(handle, CURLOPT_NOSIGNAL, 1L);
  set(handle, CURLOPT_USERAGENT, agent.c_str());
  set(handle, CURLOPT_SSL_VERIFYPEER, 1L);
  set(handle, CURLOPT_SSL_VERIFYHOST, 2L);
  if (const char* file = std::getenv("SSL_CERT_FILE"); file != nullptr && *file != '\0') set(handle, CURLOPT_CAINFO, file);
  if (std::getenv("no_proxy") == nullptr && std::getenv("NO_PROXY") == nullptr)
    set(handle, CURLOPT_NOPROXY, "localhost,127.0.0.1,::1");
  set(handle, CURLOPT_CONNECTTIMEOUT_MS, connecting_ms);
  set(handle, CURLOPT_LOW_SPEED_LIMIT, stalled_bytes_per_s);
  set(handle, CURLOPT_LOW_SPEED_TIME, stalled_s);
  set(handle, CURLOPT_TIMEOUT_MS, static_cast<long>(1000.0 * left_s));
  set(handle, CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(most_bytes()));
  set(handle, CURLOPT_ERRORBUFFER, problem_.data());
  set(handle, CURLOPT_HEADERFUNCTION, &FetchTransfer::on_header);
  set(handle, CURLOPT_HEADERDATA, static_cast<void*>(this));
  set(handle, CURLOPT_WRITEFUNCTION, &FetchTransfer::on_body);
  set(handle, CURLOPT_WRITEDATA, static_cast<void*>(this));
  if (is_part()) set(handle, CURLOPT_RANGE, range.c_str());
}

void FetchTransfer::begin(CURL* handle) {
  handle_ = handle;
  ++attempts_;
  status_ = 0, received_ = header_bytes_ = 0, range_.reset(), is_too_long_ = is_encoded_ = false, problem_.fill('\0');
  if (file_ >= 0) ::close(file_);
  file_ = ::memfd_create("palpa-fetched", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file_ < 0) throw LoadError("cannot be fetched: there is no memory for it; close other programs");
  set_options(handle);
}

std::size_t FetchTransfer::on_header(char* line, std::size_t, std::size_t bytes, void* self) {
  return static_cast<FetchTransfer*>(self)->take_header({line, bytes}) ? bytes : 0;
}

std::size_t FetchTransfer::on_body(char* part, std::size_t, std::size_t bytes, void* self) {
  return static_cast<FetchTransfer*>(self)->take_body(part, bytes) ? bytes : 0;
}

std::optional<FetchTransfer::Range> FetchTransfer::range_in(std::string_view value) {
  if (!take(value, "bytes ")) return std::nullopt;
  const auto first = number_of(value);
  if (!first || !take(value, "-")) return std::nullopt;
  const auto last = number_of(value);
  if (!last || !take(value, "/")) return std::nullopt;
  const auto whole = number_of(value);
  if (!whole || !value.empty() || *first > *last || *last >= *whole) return std::nullopt;
  return Range{*first, *last, *whole};
}

bool FetchTransfer::take_header(std::string_view line) {
  header_bytes_ += line.size();
  if (header_bytes_ > most_header_bytes) return false;
  if (const auto value = value_in(line, "content-range")) range_ = range_in(*value);
  if (const auto value = value_in(line, "content-encoding")) is_encoded_ = *value != "identity";
  return true;
}

bool FetchTransfer::take_body(const char* part, std::size_t bytes) {
  ::curl_easy_getinfo(handle_, CURLINFO_RESPONSE_CODE, &status_);
  received_ += bytes;
  if (status_ != 200 && status_ != 206) return received_ <= most_error_bytes;
  const std::uint64_t most = is_part() && status_ == 206 ? request_.bytes : most_bytes();
  is_too_long_ = received_ > most;
  if (is_too_long_) return false;
  while (bytes > 0) {
    const ssize_t written = ::write(file_, part, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    part += written, bytes -= static_cast<std::size_t>(written);
  }
  return true;
}

bool FetchTransfer::end(CURLcode code, bool server_answers, bool permits_attempts) {
  ::curl_easy_getinfo(handle_, CURLINFO_RESPONSE_CODE, &status_);
  if (finish(code)) return true;
  const bool passes = status_ == 200 || status_ == 206 || status_ == 0 ? may_pass(code) : may_pass(status_);
  const int most = was_answered() ? most_answered_attempts : most_attempts;
  if (!passes || !server_answers || (was_answered() && !permits_attempts) || attempts_ >= most || age_s() > latest_attempt_s)
    return true;
  not_before_ = Clock::now() + first_pause * (1 << (attempts_ - 1));
  return false;
}

void FetchTransfer::fail(const std::string& sentence) {
  answer_.state = protocol::FetchState::failed;
  answer_.sentence = sentence;
}

/// Sets the answer; false: it is a failure.
bool FetchTransfer::finish(CURLcode code) {
  answer_.is_forbidden = status_ == 401 || status_ == 403;
  if (status_ == 404 || status_ == 410) return answer_.state = protocol::FetchState::absent, true;
  if (status_ != 0 && status_ != 200 && status_ != 206) return fail(words_of_status()), false;
  if (code != CURLE_OK) return fail(words_of(code)), false;
  take_content();
  return answer_.state == protocol::FetchState::present;
}

void FetchTransfer::take_content() {
  if (is_encoded_) return fail("is packed by its server on the way (Content-Encoding), which was not asked for");
  if (status_ == 0) return fail("its server gave no answer by HTTP");
  if (status_ == 206) {
    const std::uint64_t whole = range_ ? range_->whole : 0, length = std::min(request_.bytes, whole);
    const std::uint64_t first = request_.from_end ? whole - length : request_.first;
    if (!is_part() || !range_ || range_->first != first || received_ != range_->last - range_->first + 1 ||
        received_ != std::min(length, whole - first))
      return fail("its server gave another part than was asked for");
    answer_.first = first, answer_.whole_bytes = whole;
  } else {
    answer_.first = 0, answer_.whole_bytes = received_;
  }
  ::fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL);
  answer_.state = protocol::FetchState::present;
}

std::string FetchTransfer::words_of_status() const {
  if (status_ >= 300 && status_ < 400) {
    const char* to = nullptr;
    ::curl_easy_getinfo(handle_, CURLINFO_REDIRECT_URL, &to);
    const std::string where = to == nullptr ? std::string("elsewhere") : "'" + std::string(to).substr(0, 300) + "'";
    return "its server leads to " + where + ", which is not followed: name the address where the files lie";
  }
  return "its server answers " + std::to_string(status_) + (answer_.is_forbidden ? ", forbidden" : "");
}

std::string FetchTransfer::words_of(CURLcode code) const {
  const std::string said = problem_.front() != '\0' ? problem_.data() : ::curl_easy_strerror(code);
  if (is_too_long_ || code == CURLE_FILESIZE_EXCEEDED) {
    return (is_part() ? "its server gives no parts of files (ranges), and it is longer than "
                      : "is longer than any sound one, of ") +
           protocol::readable_bytes(static_cast<double>(most_bytes()));
  }
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST: return "its server is unknown (" + said + ")";
    case CURLE_COULDNT_CONNECT: return "its server cannot be reached (" + said + ")";
    case CURLE_PEER_FAILED_VERIFICATION: return "the certificate of its server is not accepted (" + said + ")";
    case CURLE_OPERATION_TIMEDOUT: return "its server gave nothing for too long (" + said + ")";
    case CURLE_GOT_NOTHING:
    case CURLE_RECV_ERROR:
    case CURLE_PARTIAL_FILE: return "was cut short by its server";
    default: return "cannot be fetched (" + said + ")";
  }
}

}  // namespace palpa::reader
