"""Exceptions of check_sources.py, with reasons."""

# Namespaces whose numbers need no unit: none is used outside of its layer.
internal = r"\b(detail|phantom|scene_file)\b|namespace\s*$"
# Headers of the scene loader, which uses TOML; none is installed.
knows_toml = ("palpa/scene/set_path.h", "palpa/scene/toml_section.h")

# (what, words, folders, alternative, {file: reason})
words = [
    ("opens files", r"\b(?:fopen|freopen|fdopen|gzopen|openat|creat|mkstemp|mkostemp|tmpfile|memfd_create|mmap|linkat|renameat2?|"
     r"[io]?fstream|filebuf|QFile|QSaveFile|QTemporaryFile|QImageWriter|copy_file|parse_file)\b|"
     r"(?:(?<![\w>])|(?<=return )|\bfs|\bfilesystem)::(?:open|rename|link|symlink)\b",
     ("palpa", "reader", "app", "explorer", "devices", "net"), "palpa/base/input_file.h or new_file.h",
     {"palpa/base/input_file.cpp": "the way in", "palpa/base/mapped_file.cpp": "the way in", "palpa/base/new_file.cpp": "the way out",
      "palpa/trace/writer.cpp": "rows of a recording, which must be there when the process is killed",
      "palpa/file/shared_memory.cpp": "memory that is shared with palpa-read", "palpa/file/protocol_memory.cpp": "the same, mapped",
      "palpa/file/raw_file.cpp": "memory in large pages", "palpa/study/map.cpp": "memory that is taken when written to",
      "palpa/base/free_memory.cpp": "free memory by the system",
      "palpa/file/reader_process.cpp": "state of palpa-read by the system", "reader/serve.cpp": "state of this process by the system",
      "reader/fetch_transfer.cpp": "memory for a file that is fetched",
      "reader/sandbox.cpp": "whether the sandbox keeps a file closed"}),
    ("obeys the locale", r"\b(?:v?s?n?printf(?<!\bprintf)|vsprintf|asprintf|strto(?:d|f|ld)|atof|sto(?:d|f|ld)|[sf]scanf|put_money|"
     r"setprecision|[io]?stringstream)\b", ("palpa", "app", "explorer", "devices", "net", "python"), "detail::text, to_chars or from_chars",
     {"palpa/base/printed.cpp": "where printf is held to the C locale", "palpa/file/reader_process.cpp": "whole numbers",
      "palpa/view/offscreen.cpp": "words of a sentence", "palpa/device/open_device.cpp": "toml++ writes numbers by to_chars",
      "app/reference.cpp": "words of the command line", "devices/inverse3.cpp": "an address, in the classic locale",
      "devices/inverse3_connection.cpp": "an address, in the classic locale"}),
    ("writes to the terminal", r"\b(?:v?f?printf|f?puts|putchar|fwrite|cout|cerr)\b|fmt::print\b", ("app", "net"), "print or tell (app/terminal.h)",
     {"app/terminal.cpp": "where it is cleaned", "app/live_terminal.cpp": "where it is cleaned"})]
