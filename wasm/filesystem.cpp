// Operations of <filesystem> on WASI's files.
#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

namespace std::filesystem {
namespace {

error_code last_error() { return {errno, generic_category()}; }

/// Kind of a file, of a link its target's; 0: there is none.
mode_t kind_of(const path& of, error_code& error) noexcept {
  struct stat status{};
  error.clear();
  if (::stat(of.c_str(), &status) == 0) return status.st_mode & S_IFMT;
  if (errno != ENOENT && errno != ENOTDIR) error = last_error();
  return 0;
}

}  // namespace

bool exists(const path& of, error_code& error) noexcept { return kind_of(of, error) != 0; }
bool exists(const path& of) {
  error_code error;
  return exists(of, error);
}
bool is_directory(const path& of, error_code& error) noexcept { return kind_of(of, error) == S_IFDIR; }
bool directory_entry::is_regular_file(error_code& error) const noexcept { return kind_of(path_, error) == S_IFREG; }

bool create_directory(const path& made, error_code& error) noexcept {
  error.clear();
  if (::mkdir(made.c_str(), 0777) == 0) return true;
  if (error_code ignored; errno != EEXIST || !is_directory(made, ignored)) error = last_error();
  return false;
}

uintmax_t remove_all(const path& of, error_code& error) {
  uintmax_t removed = 0;
  if (is_directory(of, error)) {
    for (const directory_entry& entry : directory_iterator(of, error)) removed += remove_all(entry.path(), error);
    if (::rmdir(of.c_str()) != 0) error = last_error();
    return removed + 1;
  }
  if (::unlink(of.c_str()) == 0) return 1;
  if (errno != ENOENT) error = last_error();
  return 0;
}

path absolute(const path& of) { return of.is_absolute() ? of : path("/") / of; }

directory_iterator::directory_iterator(const path& folder, error_code& error) {
  error.clear();
  DIR* const open = ::opendir(folder.c_str());
  if (!open) {
    error = last_error();
    return;
  }
  vector<directory_entry> all;
  while (const dirent* const entry = ::readdir(open)) {
    const string name = entry->d_name;
    if (name != "." && name != "..") all.emplace_back(folder / name);
  }
  ::closedir(open);
  if (!all.empty()) entries_ = make_shared<const vector<directory_entry>>(std::move(all));
}

directory_iterator& directory_iterator::operator++() {
  if (++at_ == entries_->size()) *this = {};
  return *this;
}

}  // namespace std::filesystem
