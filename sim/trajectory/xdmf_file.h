// The XDMF sidecar, by which ParaView opens a trajectory: XML that names datasets of the HDF5 file.
// Private to sim/.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// A surface of one frame, as datasets of the HDF5 file.
struct XdmfSurface {
  std::string name;
  int points = 0;
  int triangles = 0;
  std::string triangle_dataset;  // [triangles, 3] int32
  std::string position_dataset;  // [points, 3] float32
  std::string velocity_dataset;  // [points, 3] float32; empty: none
  bool operator==(const XdmfSurface&) const = default;
};

// The sidecar, valid XML at any time. It is created under a temporary name and then renamed. Each
// append replaces the closing tags at the end by the frames and new closing tags, in one write.
// Cost: O(1) per frame.
class XdmfFile {
 public:
  XdmfFile() = default;
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;
  ~XdmfFile();

  // Creates the sidecar and replaces any file at `path`. `trajectory` is the name of the HDF5 file
  // in the same folder. Throws FileError.
  void create(const std::string& path, const std::string& trajectory);
  // Returns the text of a frame at `time` (s), for append().
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
  long end_ = 0;                    // offset at which the closing tags start
};

}  // namespace weft::sim
