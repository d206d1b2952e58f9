#include "tests/fuzz/input_files.h"

#include <stdlib.h>

#include <fstream>
#include <stdexcept>

namespace weft::sim {

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

InputSections split_sections(std::string_view input) {
  constexpr std::string_view mark = "=== ";
  InputSections sections;
  std::string* text = &sections.main;
  for (const std::string& line : lines_of(input)) {
    if (line.starts_with(mark)) {
      text = &sections.named.emplace_back(line.substr(mark.size()), "").second;
    } else {
      *text += line + '\n';
    }
  }
  return sections;
}

InputFolder::InputFolder() {
  // In memory, where the system has such files: a fuzzer writes thousands of them per second.
  const std::filesystem::path memory = "/dev/shm";
  const bool has_memory = std::filesystem::is_directory(memory);
  std::string pattern =
      ((has_memory ? memory : std::filesystem::temp_directory_path()) / "weft_fuzz_XXXXXX")
          .string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no folder for the input");
  path_ = pattern;
}

InputFolder::~InputFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void InputFolder::write(const std::string& name, std::string_view bytes) const {
  // Only names without folders: an input may not write elsewhere.
  if (name.empty() || name.find('/') != std::string::npos || name == "." || name == "..") return;
  std::ofstream(path_ / name, std::ios::binary) << bytes;
}

void InputFolder::clear() const {
  for (const auto& entry : std::filesystem::directory_iterator(path_)) {
    std::filesystem::remove_all(entry.path());
  }
}

const InputFolder& empty_input_folder() {
  static const InputFolder folder;
  folder.clear();
  return folder;
}

}  // namespace weft::sim
