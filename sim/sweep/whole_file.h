// Small files that are written and read as a whole.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace weft::sim {

// Writes a file under another name in the same folder and renames it, so that readers find the
// former file or the new one, whenever this process or the machine stops. Two processes that write
// the same file do not disturb each other. Throws FileError.
void write_whole_file(const std::filesystem::path& path, const std::string& text);

// Writes a file in place and does not wait for the disk: if this process or the machine stops, the
// file may be cut short. Throws FileError.
void write_file(const std::filesystem::path& path, const std::string& text);

// Waits until the disk has all bytes of a file. Throws FileError if it cannot be opened or written.
void flush_file(const std::filesystem::path& path);

// Returns the text of a file, or nothing if there is no such file. Throws FileError for a file that
// cannot be read.
std::optional<std::string> read_whole_file(const std::filesystem::path& path);

// Returns the name of this machine and the number of this process: "node7_1234".
std::string process_name();

}  // namespace weft::sim
