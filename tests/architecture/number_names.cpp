#include "number_names.h"

#include <cctype>
#include <regex>

#include "source_tokens.h"

namespace palpa::architecture {
namespace {

bool says_unit(const std::string& comment) {
  static const std::regex unit(R"re(\[1\]|\[[^\],;_(){}]*[A-Za-z][^\],;_(){}]*\]|own unit)re");
  return std::regex_search(comment, unit);
}

class Checker {
 public:
  explicit Checker(std::string_view header) : lexed_(lex(header)) {}

  std::vector<UnitlessNumber> run() {
    int parentheses = 0;
    for (const Token& token : lexed_.tokens) {
      const std::string& t = token.text;
      if (t == "(") ++parentheses;
      if (t == ")") --parentheses;
      if (parentheses > 0) {
        statement_.push_back(token);
      } else if (t == "{") {
        open();
      } else if (t == "}") {
        close();
      } else if (t == ";") {
        end_statement();
      } else if (t == ":" && !statement_.empty() && is_access(statement_.back().text)) {
        if (!scopes_.empty()) scopes_.back().open = statement_.back().text == "public";
        statement_.clear();
      } else {
        statement_.push_back(token);
      }
    }
    return found_;
  }

 private:
  struct Scope {
    bool open;         ///< numbers in it are public
    bool initialiser;  ///< part of a statement that goes on behind it
  };

  static bool is_access(const std::string& t) { return t == "public" || t == "private" || t == "protected"; }
  bool visible() const {
    for (const Scope& scope : scopes_) {
      if (!scope.open) return false;
    }
    return true;
  }

  /// The statement's first token that is not part of `template <…>`.
  std::size_t after_template() const {
    std::size_t i = 0;
    while (i < statement_.size() && statement_[i].text == "template") {
      int depth = 0;
      do {
        ++i;
        if (i < statement_.size()) depth += (statement_[i].text == "<") - (statement_[i].text == ">");
      } while (i < statement_.size() && depth > 0);
      ++i;
    }
    return i;
  }

  void open() {
    bool class_here = false, default_open = true, namespace_here = false, detail = false, function = false, enumeration = false;
    for (std::size_t i = after_template(); i < statement_.size(); ++i) {
      const std::string& t = statement_[i].text;
      if (t == "(" || t == "concept" || t == "requires") function = true;
      if (function) break;
      if (t == "namespace") namespace_here = true;
      if (t == "detail") detail = true;
      if (t == "enum") enumeration = true;
      if (t == "class" || t == "struct" || t == "union") class_here = true, default_open = t != "class";
    }
    if (function || enumeration) {
      if (function && visible()) examine();
      scopes_.push_back({false, false});
      statement_.clear();
    } else if (namespace_here) {
      scopes_.push_back({!detail, false});
      statement_.clear();
    } else if (class_here) {
      scopes_.push_back({default_open, false});
      statement_.clear();
    } else {
      scopes_.push_back({false, true});
      held_.push_back(std::move(statement_));
      statement_.clear();
    }
  }

  void close() {
    statement_.clear();
    if (scopes_.empty()) return;
    if (scopes_.back().initialiser) {
      statement_ = std::move(held_.back());
      held_.pop_back();
    }
    scopes_.pop_back();
  }

  void end_statement() {
    if (visible()) examine();
    statement_.clear();
  }

  const std::string& text(std::size_t i) const {
    static const std::string nothing = ";";
    return i < statement_.size() ? statement_[i].text : nothing;
  }

  void examine() {
    if (statement_.empty() || text(0) == "using" || text(0) == "friend") return;
    int parentheses = 0;
    for (std::size_t i = 0; i < statement_.size(); ++i) {
      parentheses += (text(i) == "(") - (text(i) == ")");
      if (text(i) != "double" && text(i) != "float" && text(i) != "Vec3") continue;
      std::size_t name = i + 1;
      while (text(name) == "const" || text(name) == "&" || text(name) == "*" || text(name) == ">" ||
             (text(name) == "," && !is_word(text(name + 1)) && text(name + 2) == ">")) {
        name += text(name) == "," ? 2 : 1;
      }
      if (!is_word(text(name)) || text(name) == "operator" || text(name + 1) == "::") continue;
      if (parentheses > 0) {
        check(name, true);
        continue;
      }
      check(name, false);
      if (text(name + 1) == "(") continue;
      for (std::size_t next = name + 1; next < statement_.size(); ++next) {  // double a = 0, b = 0;
        if (text(next) == "(") break;
        if (text(next) == "," && is_word(text(next + 1))) check(next + 1, false);
      }
    }
  }

  void check(std::size_t i, bool parameter) {
    const Token& name = statement_[i];
    if (ends_with_unit(name.text)) return;
    const std::string above = comment_above(statement_.front().line);
    const auto behind = lexed_.comments.find(name.line);
    if (parameter) {
      const std::regex named(R"re((\\param\s+|`))re" + name.text + R"re(\b[^\n]*)re");
      const std::string all = above + (behind == lexed_.comments.end() ? std::string() : behind->second);
      for (std::sregex_iterator it(all.begin(), all.end(), named), end; it != end; ++it) {
        if (says_unit(it->str())) return;
      }
    } else if (says_unit(above) || (behind != lexed_.comments.end() && says_unit(behind->second))) {
      return;
    }
    found_.push_back({name.line, name.text});
  }

  /// The lines of comment right above a line.
  std::string comment_above(int line) const {
    std::string out;
    for (int i = line - 1; lexed_.comments.contains(i) && !lexed_.lines_with_code.contains(i); --i) {
      out.insert(0, lexed_.comments.at(i) + '\n');
    }
    return out;
  }

  Lexed lexed_;
  std::vector<Scope> scopes_;
  std::vector<Token> statement_;
  std::vector<std::vector<Token>> held_;  ///< statements around an initialiser in braces
  std::vector<UnitlessNumber> found_;
};

}  // namespace

bool ends_with_unit(const std::string& name) {
  static const std::string base = "(m|mm|um|m2|m3|s|ms|us|n|j|hz|kg|deg|rad)";
  static const std::regex unit("(.*_(" + base + "|(" + base + "|ns|ticks)_per_" + base + "|per_" + base + "|bytes)|per_" +
                               base + "|newtons|metres|seconds|bytes)(_(min|max|mean|p50|p99|sum))?");
  return std::regex_match(name, unit);
}

std::vector<UnitlessNumber> unitless_numbers(std::string_view header) { return Checker(header).run(); }

}  // namespace palpa::architecture
