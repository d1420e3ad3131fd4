#include "tests/fuzz/campaign.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace palpa::fuzz {

volatile int interrupted = 0;

namespace {

using Clock = std::chrono::steady_clock;

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

constexpr std::size_t most_notes = 64;         // [1] of a round; more failures are counted, not kept
constexpr std::size_t most_choices = 1 << 20;  // [1] recorded for a case; later choices cannot be minimised
constexpr int most_jobs = 64;

struct Text {
  char characters[600];
  void set(const std::string& text) {
    const std::size_t size = text.copy(characters, sizeof characters - 1);
    characters[size] = '\0';
    std::replace(characters, characters + size, '\n', ' ');
  }
};

// Shared memory of processes. Zero at first.
template <class T>
class SharedMemory {
 public:
  SharedMemory() {
    void* memory = ::mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    shared_ = static_cast<T*>(memory);
  }
  ~SharedMemory() { ::munmap(shared_, sizeof(T)); }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  T* operator->() { return shared_; }
  T& operator*() { return *shared_; }

 private:
  T* shared_;
};

struct Note {
  std::uint64_t seed;
  Text broken;
};

struct Worker {
  std::atomic<std::uint64_t> seed;
  std::atomic<double> since_s;  // 0: between two cases
  double slowest_s, peak_bytes;
  std::uint64_t slowest_seed;
};

struct Round {
  std::atomic<std::uint64_t> next_seed;
  std::atomic<std::int64_t> tries, failures, cases, refused;
  std::atomic<std::size_t> notes;
  Note noted[most_notes];
  Worker workers[most_jobs];

  void note(std::uint64_t seed, const std::string& broken) {
    ++failures;
    const std::size_t place = notes++;
    if (place >= most_notes) return;
    noted[place].seed = seed;
    noted[place].broken.set(broken);
  }
};

struct NotedCase {
  std::uint64_t choices[most_choices];
  std::size_t taken;
  Text broken;
};

double peak_bytes() {
  double most = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    ::getrusage(who, &usage);
    most = std::max(most, 1024.0 * static_cast<double>(usage.ru_maxrss));
  }
  return most;
}

// A temporary folder; the destructor removes it.
class OwnFolder {
 public:
  OwnFolder() {
    std::string name = (fs::temp_directory_path() / "palpa-campaign-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made; set TMPDIR to another folder");
    path_ = name;
    fs::permissions(path_, fs::perms(0755));  // some cases run as other users
  }
  ~OwnFolder() { remove(path_); }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  const fs::path& path() const { return path_; }
  // Read-only content too.
  static void remove(const fs::path& folder) {
    std::error_code ignored;
    for (auto entry = fs::recursive_directory_iterator(folder, ignored); entry != fs::recursive_directory_iterator();
         entry.increment(ignored)) {
      if (entry->is_directory(ignored) && !entry->is_symlink(ignored))
        fs::permissions(entry->path(), fs::perms::owner_all, fs::perm_options::add, ignored);
    }
    fs::remove_all(folder, ignored);
  }

 private:
  fs::path path_;
};

// Calls `act` in a child process, which ends with this process and can be killed with its children.
pid_t started(const std::function<void()>& act) {
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("no process can be started; are there too many?");
  if (child > 0) {
    ::setpgid(child, child);
    return child;
  }
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  int code = 0;
  try {
    act();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    code = 1;
  }
  std::fflush(nullptr);
  ::_exit(code);
}

void kill_all_of(pid_t process) { ::kill(-process, SIGKILL); }

// Description of an abnormal exit status; empty: normal end.
std::string crash_of(int status) {
  if (WIFSIGNALED(status)) return "crashes: signal " + std::to_string(WTERMSIG(status));
  if (WEXITSTATUS(status) != 0) return "crashes: exit code " + std::to_string(WEXITSTATUS(status));
  return {};
}

std::string hang_of(const Campaign& campaign) {
  std::ostringstream text;
  text << "never ends: not within " << campaign.patience_s << " s";
  return text.str();
}

Tried tried(const Attempt& attempt, Choices& choices, const fs::path& folder) {
  OwnFolder::remove(folder);
  fs::create_directories(folder);
  const double begin_s = now_s();
  Tried result;
  try {
    result = attempt(choices, folder);
  } catch (const std::exception& error) {
    result.broken = std::string("throws: ") + error.what();
  }
  if (result.slowest_s < 0.0) result.slowest_s = now_s() - begin_s;
  return result;
}

// Sets up the shared parts of a process's cases, in a folder beside the cases' own.
Attempt begun(const Campaign& campaign, const fs::path& folder) {
  OwnFolder::remove(folder);
  fs::create_directories(folder / "shared");
  ::setenv("TMPDIR", folder.c_str(), 1);  // for all child processes
  return campaign.begin(folder / "shared");
}

void work(const Campaign& campaign, std::int64_t tries, double round_s, const fs::path& folder, Round& round, Worker& self) {
  const Attempt attempt = begun(campaign, folder);
  const double until_s = now_s() + round_s;
  while (!interrupted && now_s() < until_s && round.tries < tries) {
    const std::uint64_t seed = round.next_seed++;
    self.seed = seed;
    self.since_s = now_s();
    Choices choices(seed);
    const Tried result = tried(attempt, choices, folder / "case");
    self.since_s = 0.0;
    round.tries += result.tries;
    round.refused += result.refused;
    ++round.cases;
    if (result.slowest_s > self.slowest_s) self.slowest_s = result.slowest_s, self.slowest_seed = seed;
    self.peak_bytes = std::max(self.peak_bytes, peak_bytes());
    if (!result.broken.empty()) round.note(seed, result.broken);
  }
}

// The broken promise of one case, run in a process of its own. Its choices are recorded.
std::string broken_by(const Campaign& campaign, const Attempt& attempt, const std::function<Choices()>& choices,
                      const fs::path& folder, NotedCase& noted) {
  noted.broken.set("");
  noted.taken = 0;
  const pid_t child = started([&] {
    Choices own = choices();
    const Tried result = tried(attempt, own, folder);
    noted.taken = std::min(own.taken(), most_choices);
    noted.broken.set(result.broken);
  });
  const double begin_s = now_s();
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (now_s() - begin_s > campaign.patience_s || interrupted) {
      kill_all_of(child);
      ::waitpid(child, &status, 0);
      return interrupted ? std::string() : hang_of(campaign);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const std::string crash = crash_of(status);
  return crash.empty() ? noted.broken.characters : crash;
}

// Minimises a failure and keeps it.
void examine(const Campaign& campaign, std::uint64_t seed, const std::string& broken, const fs::path& work_folder,
             const fs::path& keep) {
  constexpr double most_s = 60.0;  // more: smaller cases; less: campaigns with many failures go on sooner
  constexpr int most_runs = 2000;
  const Attempt attempt = begun(campaign, work_folder);
  SharedMemory<NotedCase> noted;
  const fs::path folder = work_folder / "case";
  const std::string again = broken_by(
      campaign, attempt, [&] { return Choices(seed, noted->choices); }, folder, *noted);
  // A crashed case has not reported its number of choices.
  std::size_t taken = noted->taken > 0 ? noted->taken : most_choices;
  while (taken > 0 && noted->choices[taken - 1] == 0) --taken;
  std::vector<std::uint64_t> choices(noted->choices, noted->choices + taken);
  std::string text = broken;
  if (!is_same_promise(again, broken)) {
    text += " (not again: " + (again.empty() ? std::string("nothing broken") : again) + ")";
  } else {
    const double until_s = now_s() + most_s;
    choices = shrunk(std::move(choices), most_runs, [&](const std::vector<std::uint64_t>& smaller) {
      if (now_s() > until_s || interrupted) return std::string();
      return broken_by(
          campaign, attempt, [&] { return Choices(smaller); }, folder, *noted);
    });
    text = broken_by(
        campaign, attempt, [&] { return Choices(choices); }, keep / "case", *noted);
  }
  std::ofstream out(keep / "choices");
  out << "campaign " << campaign.name << "\nseed " << seed << "\nbroken " << broken << "\nsmaller " << text << "\nchoices";
  for (const std::uint64_t choice : choices) out << ' ' << choice;
  out << '\n';
}

std::string file_name_of(const std::string& name) {
  std::string file = name;
  for (char& c : file) c = std::isalnum(static_cast<unsigned char>(c)) || c == '.' ? c : '_';
  return file;
}

// \param examined  findings kept before
void keep_failures(const Campaign& campaign, const Round& round, const RunOptions& options, const fs::path& folder,
                   std::vector<std::string>& examined) {
  constexpr int most_alike = 3;  // of one promise; more findings than a person reads
  for (std::size_t n = 0; n < std::min(round.notes.load(), most_notes); ++n) {
    const Note& note = round.noted[n];
    if (options.says) *options.says << campaign.name << ", seed " << note.seed << ": " << note.broken.characters << std::endl;
    const std::string broken = note.broken.characters;
    const auto alike = std::count_if(examined.begin(), examined.end(),
                                     [&](const std::string& earlier) { return is_same_promise(earlier, broken); });
    if (options.findings.empty() || alike >= most_alike || interrupted) continue;
    examined.push_back(broken);
    const fs::path keep = options.findings / file_name_of(campaign.name) / std::to_string(note.seed);
    fs::create_directories(keep);
    const pid_t child = started([&] { examine(campaign, note.seed, broken, folder / "examined", keep); });
    int status = 0;
    ::waitpid(child, &status, 0);
    if (options.says && fs::exists(keep / "choices")) *options.says << "  kept in " << keep.string() << std::endl;
  }
}

void run_round(const Campaign& campaign, std::int64_t tries, const Row& row, const RunOptions& options, const fs::path& folder,
               Round& round) {
  round.next_seed = row.next_seed;
  std::vector<pid_t> processes(static_cast<std::size_t>(std::clamp(options.jobs, 1, most_jobs)), 0);
  const auto start = [&](std::size_t n) {
    round.workers[n].since_s = 0.0;
    processes[n] = started(
        [&] { work(campaign, tries - row.tries, options.round_s, folder / std::to_string(n), round, round.workers[n]); });
  };
  for (std::size_t n = 0; n < processes.size(); ++n) start(n);
  for (bool told = false; std::any_of(processes.begin(), processes.end(), [](pid_t process) { return process != 0; });) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (interrupted && !told) {  // each ends with its current case
      told = true;
      for (const pid_t process : processes) {
        if (process != 0) ::kill(process, SIGTERM);
      }
    }
    for (std::size_t n = 0; n < processes.size(); ++n) {
      if (processes[n] == 0) continue;
      const double since_s = round.workers[n].since_s;
      const bool hangs = since_s > 0.0 && now_s() - since_s > campaign.patience_s;
      if (hangs) kill_all_of(processes[n]);
      int status = 0;
      if (::waitpid(processes[n], &status, hangs ? 0 : WNOHANG) == 0) continue;
      processes[n] = 0;
      const std::string crash = hangs ? hang_of(campaign) : crash_of(status);
      if (crash.empty() || interrupted) continue;
      if (since_s == 0.0) throw std::runtime_error(campaign.name + ": what its cases share cannot be made; see above");
      ++round.tries;
      ++round.cases;
      round.note(round.workers[n].seed, crash);
      start(n);
    }
  }
}

}  // namespace

void run(const Campaign& campaign, std::int64_t tries, Row& row, const RunOptions& options) {
  const OwnFolder own;
  std::vector<std::string> examined;
  while (row.tries < tries && !interrupted) {
    SharedMemory<Round> round;
    const double begin_s = now_s();
    run_round(campaign, tries, row, options, own.path(), *round);
    row.next_seed = round->next_seed;
    row.tries += round->tries;
    row.failures += round->failures;
    row.cases += round->cases;
    row.refused += round->refused;
    for (const Worker& worker : round->workers) {
      if (worker.slowest_s > row.slowest_s) row.slowest_s = worker.slowest_s, row.slowest_seed = worker.slowest_seed;
      row.peak_bytes = std::max(row.peak_bytes, worker.peak_bytes);
    }
    row.spent_s += (now_s() - begin_s) * std::clamp(options.jobs, 1, most_jobs);
    keep_failures(campaign, *round, options, own.path(), examined);
    if (options.save) options.save(row);
    if (round->cases == 0 && !interrupted) {
      ++row.failures;
      throw std::runtime_error(campaign.name + ": no case could be tried; look at what it prints");
    }
  }
}

std::vector<std::uint64_t> shrunk(std::vector<std::uint64_t> choices, int most,
                                  const std::function<std::string(const std::vector<std::uint64_t>&)>& broken) {
  const std::string promise = broken(choices);
  const auto take = [&](std::vector<std::uint64_t> smaller) {
    while (!smaller.empty() && smaller.back() == 0) smaller.pop_back();
    if (most <= 0 || smaller == choices) return false;
    --most;
    if (!is_same_promise(broken(smaller), promise)) return false;
    choices = std::move(smaller);
    return true;
  };
  const auto begin = [&](std::size_t at) { return static_cast<std::ptrdiff_t>(at); };
  for (bool goes_on = true; goes_on && most > 0;) {
    goes_on = false;
    // Without a part, from the end on; then with zeros in its place.
    for (std::size_t part = std::max<std::size_t>(choices.size() / 2, 1); part > 0 && most > 0; part /= 2) {
      for (std::size_t end = choices.size(); end >= part && end <= choices.size() && most > 0;) {
        std::vector<std::uint64_t> without = choices, zeros = choices;
        without.erase(without.begin() + begin(end - part), without.begin() + begin(end));
        std::fill(zeros.begin() + begin(end - part), zeros.begin() + begin(end), 0);
        if (take(std::move(without)) || take(std::move(zeros))) goes_on = true;
        end = end > part ? std::min(end - part, choices.size()) : 0;
      }
    }
    for (std::size_t n = 0; n < choices.size() && most > 0; ++n) {
      for (std::uint64_t step = choices[n]; step > 0 && n < choices.size(); step /= 2) {
        if (choices[n] < step) continue;
        std::vector<std::uint64_t> less = choices;
        less[n] -= step;
        if (take(std::move(less))) goes_on = true;
      }
    }
  }
  return choices;
}

bool is_same_promise(const std::string& a, const std::string& b) {
  return a.substr(0, a.find(": ")) == b.substr(0, b.find(": "));
}

Table load_table(const fs::path& file) {
  Table table;
  std::ifstream in(file);
  std::string line;
  if (!in) return table;
  while (std::getline(in, line)) {
    const std::size_t tab = line.find('\t');
    std::istringstream cells(tab == std::string::npos ? std::string() : line.substr(tab + 1));
    Row row;
    if (!(cells >> row.next_seed >> row.tries >> row.failures >> row.cases >> row.refused >> row.slowest_s >>
          row.slowest_seed >> row.peak_bytes >> row.spent_s)) {
      throw std::runtime_error(file.string() + ": is no table of campaigns; name another file");
    }
    table[line.substr(0, tab)] = row;
  }
  return table;
}

void save_table(const fs::path& file, const Table& table) {
  const fs::path next = file.string() + ".next";
  {
    std::ofstream out(next);
    out << std::setprecision(17);
    for (const auto& [name, row] : table) {
      out << name << '\t' << row.next_seed << '\t' << row.tries << '\t' << row.failures << '\t' << row.cases << '\t'
          << row.refused << '\t' << row.slowest_s << '\t' << row.slowest_seed << '\t' << row.peak_bytes << '\t' << row.spent_s
          << '\n';
    }
    if (!out.flush()) throw std::runtime_error(next.string() + ": cannot be written; is the disk full?");
  }
  fs::rename(next, file);
}

void print_table(std::ostream& out, const Table& table, const std::vector<Campaign>& campaigns) {
  out << "| campaign | tries | failures | slowest / ms (seed) | largest memory / MB | machine time / h | cases (refused in "
         "words) "
         "|\n|---|---|---|---|---|---|---|\n"
      << std::fixed;
  Row all;
  for (const Campaign& campaign : campaigns) {
    const auto found = table.find(campaign.name);
    if (found == table.end()) continue;
    const Row& row = found->second;
    out << "| " << campaign.name << " | " << row.tries << ' ' << campaign.of << " | " << row.failures << " | "
        << std::setprecision(3) << 1e3 * row.slowest_s << " (" << row.slowest_seed << ") | " << std::setprecision(0)
        << row.peak_bytes / 1e6 << " | " << std::setprecision(3) << row.spent_s / 3600.0 << " | " << row.cases << " ("
        << row.refused << ") |\n";
    all.failures += row.failures;
    all.peak_bytes = std::max(all.peak_bytes, row.peak_bytes);
    all.spent_s += row.spent_s;
  }
  out << "| all | | " << all.failures << " | | " << std::setprecision(0) << all.peak_bytes / 1e6 << " | "
      << std::setprecision(3) << all.spent_s / 3600.0 << " | |\n";
}

Finding load_finding(const fs::path& file) {
  std::ifstream in(file);
  Finding finding;
  std::string line;
  bool has_choices = false;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "campaign") finding.campaign = line.substr(word.size() + 1);
    if (word != "choices") continue;
    has_choices = true;
    for (std::uint64_t choice = 0; words >> choice;) finding.choices.push_back(choice);
  }
  if (finding.campaign.empty() || !has_choices)
    throw std::runtime_error(file.string() + ": is no finding of a campaign; name the file 'choices' of one");
  return finding;
}

}  // namespace palpa::fuzz
