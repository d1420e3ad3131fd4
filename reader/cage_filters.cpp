// Build step: compiles the sandbox's filters into cage_filters.inc, which would take too long at each reader's start.
#include <linux/filter.h>
#include <seccomp.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "cage_calls.h"

namespace palpa::reader {
namespace {

class Filter {
 public:
  explicit Filter(std::uint32_t otherwise) : filter_(::seccomp_init(otherwise)) {
    // Calls of another architecture, such as int 0x80.
    ::seccomp_attr_set(filter_, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
    ::seccomp_attr_set(filter_, SCMP_FLTATR_CTL_OPTIMIZE, 2);  // a tree, not a list
  }
  ~Filter() { ::seccomp_release(filter_); }
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;

  void add(const Rule& rule) {
    const int number = ::seccomp_syscall_resolve_name(rule.call.c_str());
    if (number < 0) return;  // no such call on this machine
    const std::uint32_t action = rule.answer == allowed   ? SCMP_ACT_ALLOW
                                 : rule.answer == refused ? SCMP_ACT_ERRNO(EACCES)
                                 : rule.answer == missing ? SCMP_ACT_ERRNO(ENOSYS)
                                                          : SCMP_ACT_KILL_PROCESS;
    std::vector<scmp_arg_cmp> conditions;
    for (const Condition& c : rule.when) conditions.push_back(SCMP_CMP64(c.argument, SCMP_CMP_MASKED_EQ, c.mask, c.value));
    if (::seccomp_rule_add_array(filter_, action, number, static_cast<unsigned>(conditions.size()), conditions.data()) != 0)
      throw std::runtime_error(rule.call + ": its rule cannot be added");
  }
  void add(const Calls& group) {
    std::istringstream names(group.names);
    for (std::string call; names >> call;) add(Rule{group.answer, call});
  }

  /// In the kernel's format.
  std::vector<sock_filter> program() const {
    int ends[2];  // holds 64 KiB, far more than any filter
    if (::pipe(ends) != 0 || ::seccomp_export_bpf(filter_, ends[1]) != 0) throw std::runtime_error("no filter can be made");
    ::close(ends[1]);
    std::vector<sock_filter> program;
    for (sock_filter step{}; ::read(ends[0], &step, sizeof step) == sizeof step;) program.push_back(step);
    ::close(ends[0]);
    return program;
  }

 private:
  scmp_filter_ctx filter_;
};

void print(const char* name, const std::vector<sock_filter>& program) {
  std::printf("constexpr sock_filter %s[] = {\n", name);
  for (const sock_filter& step : program) std::printf("    {%#x, %d, %d, %#x},\n", step.code, step.jt, step.jf, step.k);
  std::printf("};\n");
}

void print_filters() {
  ::seccomp_api_set(4);  // of the target kernels, whatever this kernel lacks
  Filter allows(SCMP_ACT_ERRNO(ENOSYS));
  for (const Calls& group : calls) allows.add(group);
  allows.add(Calls{allowed, calls_to_become});
  for (const Rule& rule : rules_of_arguments()) allows.add(rule);
  const std::vector<sock_filter> allowing = allows.program();
  if (std::ranges::count(allowing, own_process, &sock_filter::k) != 1)
    throw std::runtime_error("the place of the process's own number is not found");
  print("allowed_calls", allowing);
  Filter closes(SCMP_ACT_ALLOW);  // calls of the first filter
  closes.add(Calls{ended, calls_to_become});
  print("no_more_programs", closes.program());
  Filter connects(SCMP_ACT_ALLOW);
  for (const Calls& group : calls_with_network) connects.add(group);
  for (const Rule& rule : rules_with_network()) connects.add(rule);
  print("filter_with_network", connects.program());
}

}  // namespace
}  // namespace palpa::reader

int main() {
  try {
    palpa::reader::print_filters();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpa_cage_filters: %s\n", error.what());
    return 1;
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
