// The sidecar with which ParaView opens a trajectory: XML that names data sets of the HDF5 file.
// Private to sim/.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// A surface of one frame, as data sets of the HDF5 file.
struct XdmfSurface {
  std::string name;
  int points = 0;
  int triangles = 0;
  std::string triangle_dataset;  // [triangles, 3] int32
  std::string position_dataset;  // [points, 3] float32
  std::string velocity_dataset;  // the same; empty: none
  bool operator==(const XdmfSurface&) const = default;
};

// The sidecar is written under a temporary name and renamed when it is made; frames replace the
// closing tags at its end with themselves and new closing tags, in one write: O(1) a frame, and a
// process that dies leaves valid XML.
class XdmfFile {
 public:
  XdmfFile() = default;
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;
  ~XdmfFile();

  // `trajectory` is the name of the HDF5 file, in the same folder. Replaces what is at `path`.
  // Throws FileError.
  void create(const std::string& path, const std::string& trajectory);
  // Returns the text of a frame at `time` (s), to be appended.
  std::string describe(double time, const std::vector<XdmfSurface>& surfaces);
  // Writes the texts of one frame or more. Throws FileError.
  void append(const std::string& frames);

 private:
  struct SurfaceText {
    XdmfSurface surface;
    std::string text;
  };
  std::string text_of(const XdmfSurface& surface) const;
  const std::string& kept_text_of(std::size_t place, const XdmfSurface& surface);
  void write_at(long offset, const std::string& text) const;

  std::string path_;
  std::string trajectory_;
  int descriptor_ = -1;
  std::vector<SurfaceText> texts_;  // of the last frame
  long end_ = 0;                    // of the frames, where the closing tags start
};

}  // namespace weft::sim
