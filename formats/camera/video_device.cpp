#include "formats/camera/video_device.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::uint32_t kBuffers = 4;
constexpr int kMaxVideoSide = 16384;

std::string reason(int error) { return std::strerror(error); }

std::uint8_t code(double value) { return std::uint8_t(std::clamp(value + 0.5, 0.0, 255.0)); }

// ITU-R BT.601 with 219 steps of luma and 224 of chroma.
void storePixel(double y, double u, double v, std::uint8_t* rgb) {
    const double luma = 255.0 / 219 * (y - 16);
    rgb[0] = code(luma + 1.596027 * v);
    rgb[1] = code(luma - 0.391762 * u - 0.812968 * v);
    rgb[2] = code(luma + 2.017232 * u);
}

v4l2_buffer captureBuffer() {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
}

// The camera's time stamp, which counts as the steady clock does unless the driver says otherwise.
std::optional<std::chrono::steady_clock::time_point> takenAt(const v4l2_buffer& buffer) {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return std::nullopt;
    return std::chrono::steady_clock::time_point(std::chrono::seconds(buffer.timestamp.tv_sec) +
                                                 std::chrono::microseconds(buffer.timestamp.tv_usec));
}

}  // namespace

VideoCalls systemVideoCalls() {
    return {[](const char* path, int flags) { return ::open(path, flags); },
            [](int file, unsigned long request, void* argument) { return ::ioctl(file, request, argument); },
            [](std::size_t length, int file, std::int64_t offset) {
                return ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, file, offset);
            },
            [](void* start, std::size_t length) { return ::munmap(start, length); },
            [](int file, int milliseconds) {
                pollfd wanted{file, POLLIN, 0};
                const int ready = ::poll(&wanted, 1, milliseconds);
                if (ready <= 0 || (wanted.revents & POLLIN)) return ready;
                errno = ENODEV;  // the camera is gone, and poll() would return at once for ever
                return -1;
            },
            [](int file) { return ::close(file); }};
}

VideoDevice::VideoDevice(const std::filesystem::path& path, int width, int height, VideoCalls calls)
    : calls_(std::move(calls)), name_(path.string()) {
    file_ = calls_.open(name_.c_str(), O_RDWR | O_NONBLOCK);
    if (file_ < 0) throw IoError(name_ + ": cannot be opened (" + reason(errno) + ")");
    try {
        chooseFormat(width, height);
        mapBuffers();
        int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        demand(VIDIOC_STREAMON, &type, "does not start");
    } catch (...) {
        release();
        throw;
    }
}

VideoDevice::~VideoDevice() {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request(VIDIOC_STREAMOFF, &type);
    release();
}

void VideoDevice::release() {
    for (const Buffer& buffer : buffers_) calls_.unmap(buffer.start, buffer.length);
    buffers_.clear();
    calls_.close(file_);
}

int VideoDevice::request(unsigned long what, void* argument) {
    int result = 0;
    do result = calls_.ioctl(file_, what, argument);
    while (result < 0 && errno == EINTR);
    return result;
}

void VideoDevice::demand(unsigned long what, void* argument, const char* step) {
    if (request(what, argument) < 0) throw IoError(name_ + ": the camera " + step + " (" + reason(errno) + ")");
}

bool VideoDevice::tryFormat(std::uint32_t pixels, int width, int height) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = std::uint32_t(width);
    format.fmt.pix.height = std::uint32_t(height);
    format.fmt.pix.pixelformat = pixels;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    if (request(VIDIOC_S_FMT, &format) < 0) {
        if (errno == EINVAL) return false;
        throw IoError(name_ + ": the camera takes no format (" + reason(errno) + ")");
    }
    const v4l2_pix_format& got = format.fmt.pix;  // the driver says what it will send instead
    if (got.pixelformat != pixels) return false;
    if (got.width < 1 || got.height < 1 || got.width > kMaxVideoSide || got.height > kMaxVideoSide)
        throw IoError(name_ + ": the camera offers pictures of " + std::to_string(got.width) + " x " +
                      std::to_string(got.height) + " pixels");
    width_ = int(got.width);
    height_ = int(got.height);
    stride_ = std::max(int(std::min(got.bytesperline, 4u * kMaxVideoSide)), 2 * width_);
    return true;
}

void VideoDevice::chooseFormat(int width, int height) {
    v4l2_capability about{};
    if (request(VIDIOC_QUERYCAP, &about) < 0) throw Unsupported(name_ + ": is not a camera (" + reason(errno) + ")");
    const std::uint32_t can = about.capabilities & V4L2_CAP_DEVICE_CAPS ? about.device_caps : about.capabilities;
    if (!(can & V4L2_CAP_VIDEO_CAPTURE) || !(can & V4L2_CAP_STREAMING))
        throw Unsupported(name_ + ": takes no pictures, or cannot stream them");
    jpeg_ = tryFormat(V4L2_PIX_FMT_MJPEG, width, height);
    if (!jpeg_ && (!tryFormat(V4L2_PIX_FMT_YUYV, width, height) || width_ % 2 != 0))
        throw Unsupported(name_ + ": sends neither MJPEG nor YUYV");
}

void VideoDevice::mapBuffers() {
    v4l2_requestbuffers wanted{};
    wanted.count = kBuffers;
    wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    wanted.memory = V4L2_MEMORY_MMAP;
    demand(VIDIOC_REQBUFS, &wanted, "gives no buffers");
    if (wanted.count < 2) throw IoError(name_ + ": the camera gives fewer than two buffers");
    for (std::uint32_t i = 0; i < wanted.count; ++i) {
        v4l2_buffer buffer = captureBuffer();
        buffer.index = i;
        demand(VIDIOC_QUERYBUF, &buffer, "hides a buffer");
        void* start = calls_.map(buffer.length, file_, std::int64_t(buffer.m.offset));
        if (start == MAP_FAILED)
            throw IoError(name_ + ": a buffer of the camera cannot be mapped (" + reason(errno) + ")");
        buffers_.push_back({start, buffer.length});
        demand(VIDIOC_QBUF, &buffer, "takes no buffer");
    }
}

bool VideoDevice::await(std::chrono::steady_clock::time_point end) {
    while (true) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
        const int ready = calls_.wait(file_, int(std::max<std::int64_t>(left.count(), 0)));
        if (ready > 0) return true;
        if (ready == 0) return false;
        if (errno != EINTR) throw IoError(name_ + ": cannot wait for the camera (" + reason(errno) + ")");
    }
}

void VideoDevice::giveBack(std::uint32_t index) {
    v4l2_buffer buffer = captureBuffer();
    buffer.index = index;
    demand(VIDIOC_QBUF, &buffer, "takes no buffer back");
}

// Takes what the camera has filled, and gives all but the newest back unread. None: it has filled nothing.
std::optional<VideoDevice::Filled> VideoDevice::takeNewest() {
    std::optional<Filled> newest;
    while (true) {
        v4l2_buffer buffer = captureBuffer();
        if (request(VIDIOC_DQBUF, &buffer) < 0) {
            if (errno != EAGAIN) throw IoError(name_ + ": the camera is gone (" + reason(errno) + ")");
            return newest;
        }
        if (buffer.index >= buffers_.size()) throw IoError(name_ + ": the camera names a buffer that it has not given");
        if (buffer.flags & V4L2_BUF_FLAG_ERROR) {
            giveBack(buffer.index);
            continue;
        }
        if (newest) giveBack(newest->index);
        newest = Filled{buffer.index, std::min<std::size_t>(buffer.bytesused, buffers_[buffer.index].length),
                        takenAt(buffer)};
    }
}

TexturePicture VideoDevice::next(std::chrono::milliseconds patience) {
    std::optional<TexturePicture> picture = poll(patience);
    if (!picture) throw IoError(name_ + (damaged_ ? ": every picture that comes is damaged" : ": no picture comes"));
    return std::move(*picture);
}

std::optional<TexturePicture> VideoDevice::poll(std::chrono::milliseconds patience) {
    const auto end = std::chrono::steady_clock::now() + patience;
    for (bool last = false;;) {
        const std::optional<Filled> filled = takeNewest();
        if (!filled) {
            if (last || !await(end)) return std::nullopt;
            last = std::chrono::steady_clock::now() >= end;  // a driver may say that there is a picture, and have none
            continue;
        }
        std::optional<TexturePicture> picture;
        try {
            picture = decode(buffers_[filled->index], filled->bytes);
            damaged_ = false;
        } catch (const InvalidInput&) {  // a JPEG that was damaged on its way: the next one will do
            damaged_ = true;
        }
        giveBack(filled->index);
        taken_ = filled->taken;
        if (picture) return picture;
        if (std::chrono::steady_clock::now() >= end) return std::nullopt;
    }
}

TexturePicture VideoDevice::decode(const Buffer& buffer, std::size_t bytes) const {
    const std::span<const std::byte> data(static_cast<const std::byte*>(buffer.start), bytes);
    if (!jpeg_) {
        if (bytes < std::size_t(stride_) * std::size_t(height_ - 1) + 2 * std::size_t(width_))
            throw InvalidInput(name_ + ": a picture is cut short");
        return fromYuyv(data, width_, height_, stride_);
    }
    TexturePicture picture = decodeTexture(data, name_);
    if (picture.width != width_ || picture.height != height_)
        throw InvalidInput(name_ + ": a picture has another size");
    return picture;
}

TexturePicture fromYuyv(std::span<const std::byte> bytes, int width, int height, int stride) {
    TexturePicture out{width, height, std::vector<std::uint8_t>(3 * std::size_t(width) * std::size_t(height))};
    std::uint8_t* rgb = out.rgb.data();
    for (int row = 0; row < height; ++row) {
        const std::byte* pair = bytes.data() + std::size_t(row) * std::size_t(stride);
        for (int x = 0; x < width; x += 2, pair += 4, rgb += 6) {
            const double u = double(pair[1]) - 128, v = double(pair[3]) - 128;
            storePixel(double(pair[0]), u, v, rgb);
            storePixel(double(pair[2]), u, v, rgb + 3);
        }
    }
    return out;
}

}  // namespace penumbra
