// The folder of a run: its state lies in its files alone.
//
//   runs/HASH/run.toml      the case
//   runs/HASH/run.h5, .xdmf the trajectory, and run.checkpoint beside it
//   runs/HASH/log.txt       the messages of the run
//   runs/HASH/result.json   the end of the run; written last, aside and renamed
//   runs/HASH/attempt_*/    the files of a run that goes on or was interrupted
//   runs/HASH/in_use        locked by the worker that is at the run; there while it is
//
// HASH are the first 16 digits of the hash of the run. The lock keeps two workers from computing a
// run at once or one after the other. Where a file system has no locks, two workers would write
// into attempts of different names: no file would have bytes of both, but the run would be done
// twice.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace weft::sim {

// The end of a run.
struct RunResult {
  // The kind of the failure; `none` for a run that is done.
  enum class Failure {
    none,
    bad_case,      // the case cannot be simulated, for example because bodies start in each other
    numerical,     // weft run ended with a numerical failure
    input_output,  // a file could not be read or written, or memory could not be had
    over_time,     // limits.time
    over_memory,   // limits.memory
    signal         // a crash, or a signal from outside
  };
  std::string hash;
  Failure failure = Failure::none;
  std::string reason;  // of a failure, in words
  int exit_code = 0;   // of weft run; meaningless after a signal
  int signal = 0;      // signal that ended the process, or 0
  int attempts = 1;
  double wall_seconds = 0, cpu_seconds = 0;
  double peak_memory = 0;  // MiB, resident
  std::string version;     // of Weft
  std::string report;      // JSON object that weft run printed; empty in a result that was read
  // Outputs of the sweep by their expressions, as the trajectory had them when the run ended; NaN
  // for what does not exist. Outputs that cannot be computed are left out.
  std::map<std::string, double> outputs;

  bool is_done() const { return failure == Failure::none; }
};

// Returns the name of a failure as result.json and tables write it: "over_time".
const char* failure_name(RunResult::Failure failure);

enum class RunState { not_begun, running, interrupted, done, failed };
// Returns the state in words: "not begun".
const char* state_name(RunState state);

// The files of a run while it goes on. The lock of the run is held until the object and all
// processes that inherit lock_descriptor() are gone.
class RunAttempt {
 public:
  ~RunAttempt();
  RunAttempt(RunAttempt&& other) noexcept;
  RunAttempt& operator=(RunAttempt&&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  int lock_descriptor() const { return lock_; }
  // True if the attempt has a checkpoint of an earlier one, from which the run can go on.
  bool resumes() const { return resumes_; }
  // True if no other worker has taken the folder over.
  bool is_ours() const { return std::filesystem::exists(folder_); }
  // Returns the reason why no attempt can go on from the checkpoint: it is damaged, or it belongs
  // to another version of Weft, case or trajectory. Returns an empty text for a checkpoint from
  // which the run can go on, and if the files cannot be read at present, which tells nothing.
  std::string fault_of_checkpoint(const std::string& case_text, bool estimates_error) const;

 private:
  friend class RunFolder;
  RunAttempt(std::filesystem::path folder, int lock, bool resumes)
      : folder_(std::move(folder)), lock_(lock), resumes_(resumes) {}

  std::filesystem::path folder_;
  int lock_;
  bool resumes_;
};

class RunFolder {
 public:
  // `sweep` is the folder of the sweep.
  RunFolder(const std::filesystem::path& sweep, const std::string& hash);

  const std::filesystem::path& path() const { return path_; }

  // Returns the result, or nothing while the run has not ended. A file that is damaged, or that
  // belongs to another hash with the same first digits, counts as no result.
  std::optional<RunResult> result() const;
  // Returns a text that is another one after each attempt that ended with a result; empty without a
  // result.
  std::string result_mark() const;
  // Returns the state of a run without a result.
  RunState state_without_result() const;

  struct Start {
    // result_mark() of the failure that the attempt is to replace; empty for a run without a
    // result.
    std::string replaced;
    bool anew = false;  // removes the files of earlier attempts instead of going on with them
  };
  // Begins an attempt with the case as run.toml. Returns nothing if another worker is at this run,
  // or if the run has another result than start.replaced. The attempt takes over the files of an
  // attempt that was interrupted or, if the run has failed, of that run, whose result it removes.
  // Throws FileError.
  std::optional<RunAttempt> begin(const std::string& case_text, const Start& start) const;
  std::optional<RunAttempt> begin(const std::string& case_text) const {
    return begin(case_text, Start());
  }

  // Moves the files of the attempt into the folder, then writes the result. All are on the disk
  // before the result is, so that a result has its files if the machine stops. Returns false if the
  // attempt was taken over by another worker; nothing is then written. Throws FileError.
  bool finish(RunAttempt attempt, const RunResult& result) const;
  // Removes the files of the attempt, so that the run begins anew when it is next computed. Leaves
  // an attempt alone that was taken over by another worker.
  void discard(RunAttempt attempt) const;

 private:
  std::filesystem::path lock_path() const { return path_ / "in_use"; }
  // Returns the descriptor of the lock of this run, or -1 if another worker holds it.
  int lock() const;
  // Makes the folder of an attempt, with the files of an earlier one unless `anew`. Returns its
  // path, or an empty one if another worker was quicker, which takes a file system without locks.
  std::filesystem::path make_attempt_folder(bool anew) const;
  // Moves the files of a run that has failed, or whose finish() was cut short, into the attempt, or
  // removes them if `anew`.
  void take_over_files(const std::filesystem::path& attempt, bool anew) const;

  std::filesystem::path path_;
  std::string hash_;
};

}  // namespace weft::sim
