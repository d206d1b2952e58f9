// The parts of an input, and a folder for the files among them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace weft::sim {

// The input up to the first line `=== NAME`, and the text below each of these lines by its name.
struct InputSections {
  std::string main;
  std::vector<std::pair<std::string, std::string>> named;
};
InputSections split_sections(std::string_view input);

// Returns the lines of a text, without the characters that end them.
std::vector<std::string> lines_of(std::string_view text);

// A folder for the files of one input at a time. It is removed at the end of the process.
class InputFolder {
 public:
  InputFolder();
  ~InputFolder();
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  void write(const std::string& name, std::string_view bytes) const;
  void clear() const;

 private:
  std::filesystem::path path_;
};

// Returns the folder of this process, empty.
const InputFolder& empty_input_folder();

}  // namespace weft::sim
