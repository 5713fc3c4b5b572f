#pragma once
// Reads pictures from a camera of this machine, by Video4Linux2 (linux/videodev2.h): MJPEG where the camera has it,
// else YUYV. Its system calls stand behind VideoCalls, so that a test can be the camera.
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/image/texture_file.h"

namespace penumbra {

// The calls of the operating system that a camera takes; each returns what the call of that name returns, and sets
// errno.
struct VideoCalls {
    std::function<int(const char* path, int flags)> open;
    std::function<int(int file, unsigned long request, void* argument)> ioctl;
    std::function<void*(std::size_t length, int file, std::int64_t offset)> map;
    std::function<int(void* start, std::size_t length)> unmap;
    std::function<int(int file, int milliseconds)>
        wait;  // poll() for input: 1 there is some, 0 time is over, -1 also where the camera has failed
    std::function<int(int file)> close;
};
VideoCalls systemVideoCalls();

class VideoDevice {
public:
    // Asks for pictures of this size, of which a camera may make another: see width(). Throws IoError where the file
    // cannot be opened or the camera fails, and Unsupported for a file that is no camera and for one without MJPEG and
    // YUYV.
    VideoDevice(const std::filesystem::path& path, int width, int height, VideoCalls calls = systemVideoCalls());
    ~VideoDevice();
    VideoDevice(const VideoDevice&) = delete;
    VideoDevice& operator=(const VideoDevice&) = delete;

    int width() const { return width_; }
    int height() const { return height_; }

    // Waits for a picture and returns the newest that is there; older ones, which wait since the last call, are
    // dropped, so that what is shown lags by no queue. Damaged pictures are passed over. Throws IoError where none
    // comes for `patience`, or the camera is gone.
    TexturePicture next(std::chrono::milliseconds patience = std::chrono::seconds(5));
    // The same, but returns nothing where none comes for `patience`.
    std::optional<TexturePicture> poll(std::chrono::milliseconds patience);
    // When the camera took the picture that was returned last; none where it does not say.
    std::optional<std::chrono::steady_clock::time_point> taken() const { return taken_; }

private:
    struct Buffer {
        void* start = nullptr;
        std::size_t length = 0;
    };
    VideoCalls calls_;
    std::string name_;
    int file_ = -1, width_ = 0, height_ = 0, stride_ = 0;
    bool jpeg_ = false, damaged_ = false;  // damaged: the picture that came last
    std::optional<std::chrono::steady_clock::time_point> taken_;
    std::vector<Buffer> buffers_;

    struct Filled {
        std::uint32_t index = 0;
        std::size_t bytes = 0;
        std::optional<std::chrono::steady_clock::time_point> taken = {};
    };

    int request(unsigned long what, void* argument);
    void demand(unsigned long what, void* argument, const char* step);
    void chooseFormat(int width, int height);
    bool tryFormat(std::uint32_t pixels, int width, int height);
    void mapBuffers();
    void release();
    void giveBack(std::uint32_t index);
    std::optional<Filled> takeNewest();
    bool await(std::chrono::steady_clock::time_point end);
    TexturePicture decode(const Buffer& buffer, std::size_t bytes) const;
};

// Returns the codes of packed 4:2:2 (Y U Y V) with the limited range of ITU-R BT.601, as cameras send it. `stride` is
// bytes a row, at least 2 width, which is even.
TexturePicture fromYuyv(std::span<const std::byte> bytes, int width, int height, int stride);

}  // namespace penumbra
