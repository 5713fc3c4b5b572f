// Cameras of this machine, played by a test in place of the operating system's calls.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <deque>

#include "formats/camera/video_device.h"
#include "formats/common/errors.h"
#include "tests/formats/tiny_jpeg.h"

namespace penumbra::test_video_device {
namespace {

using ::testing::HasSubstr;

// A camera with four buffers. What is pushed to `pictures` comes at the next calls, the oldest first.
struct FakeCamera {
    struct Picture {
        std::string bytes;
        std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    };
    std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    std::vector<std::uint32_t> formats{V4L2_PIX_FMT_YUYV};
    std::uint32_t width = 2, height = 2, stride = 0;
    std::deque<Picture> pictures;
    std::array<std::vector<char>, 4> memory;
    std::deque<std::uint32_t> queued;
    int opened = 0, mapped = 0, streaming = 0, error_of_dequeue = EAGAIN;

    int fail(int error) {
        errno = error;
        return -1;
    }
    int setFormat(v4l2_pix_format& pix) {
        if (std::ranges::find(formats, pix.pixelformat) == formats.end()) {
            if (formats.empty()) return fail(EINVAL);
            pix.pixelformat = formats[0];  // drivers do the same
        }
        pix.width = width;
        pix.height = height;
        pix.bytesperline = stride;
        return 0;
    }
    int dequeue(v4l2_buffer& buffer) {
        if (pictures.empty() || queued.empty()) return fail(error_of_dequeue);
        buffer.index = queued.front();
        queued.pop_front();
        buffer.flags = pictures.front().flags;
        buffer.bytesused = std::uint32_t(pictures.front().bytes.size());
        std::ranges::copy(pictures.front().bytes, memory[buffer.index].begin());
        const auto now = std::chrono::steady_clock::now().time_since_epoch() - std::chrono::milliseconds(250);
        buffer.timestamp.tv_sec = std::chrono::duration_cast<std::chrono::seconds>(now).count();
        buffer.timestamp.tv_usec = std::chrono::duration_cast<std::chrono::microseconds>(now).count() % 1000000;
        pictures.pop_front();
        return 0;
    }
    int control(unsigned long request, void* argument) {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        switch (request) {
            case VIDIOC_QUERYCAP:
                static_cast<v4l2_capability*>(argument)->capabilities = capabilities;
                return 0;
            case VIDIOC_S_FMT:
                return setFormat(static_cast<v4l2_format*>(argument)->fmt.pix);
            case VIDIOC_REQBUFS:
                return 0;
            case VIDIOC_QUERYBUF:
                buffer.length = 4096, buffer.m.offset = buffer.index * 4096;
                return 0;
            case VIDIOC_QBUF:
                queued.push_back(buffer.index);
                return 0;
            case VIDIOC_DQBUF:
                return dequeue(buffer);
            case VIDIOC_STREAMON:
                streaming = 1;
                return 0;
            case VIDIOC_STREAMOFF:
                streaming = 0;
                return 0;
        }
        return fail(ENOTTY);
    }
    VideoCalls calls() {
        return {[this](const char*, int) { return ++opened, 7; },
                [this](int file, unsigned long request, void* argument) {
                    return file == 7 ? control(request, argument) : fail(EBADF);
                },
                [this](std::size_t length, int, std::int64_t offset) -> void* {
                    memory[std::size_t(offset / 4096)].resize(length);
                    return ++mapped, memory[std::size_t(offset / 4096)].data();
                },
                [this](void*, std::size_t) { return --mapped, 0; },
                [this](int, int) { return pictures.empty() ? 0 : 1; },
                [this](int) { return --opened, 0; }};
    }
};

// 2 x 2 pixels: a row of white and black, and a row of one grey with red-difference chroma 128 + 50.
const std::string kYuyv("\xeb\x80\x10\x80\x7e\x80\x7e\xb2", 8);

std::string problemOf(FakeCamera& camera) {
    try {
        VideoDevice device("/dev/video9", 640, 480, camera.calls());
        (void)device.next(std::chrono::milliseconds(1));
    } catch (const std::exception& problem) {
        EXPECT_EQ(camera.opened, 0);
        EXPECT_EQ(camera.mapped, 0);
        return problem.what();
    }
    return "none";
}

TEST(VideoDevice, ReadsYuyvInLimitedRange) {
    FakeCamera camera;
    camera.pictures = {{kYuyv}};
    {
        VideoDevice device("/dev/video9", 640, 480, camera.calls());
        EXPECT_EQ(device.width(), 2);  // the camera's own size
        EXPECT_EQ(camera.streaming, 1);
        const TexturePicture picture = device.next();
        // (126 - 16) 255/219 = 128.08; red + 1.596 50 = 207.9, green - .813 50 = 87.4
        EXPECT_THAT(picture.rgb, ::testing::ElementsAre(255, 255, 255, 0, 0, 0, 208, 87, 128, 208, 87, 128));
        ASSERT_TRUE(device.taken().has_value());
        const std::chrono::duration<double> age = std::chrono::steady_clock::now() - *device.taken();
        EXPECT_NEAR(age.count(), 0.25, 0.2);
    }
    EXPECT_EQ(camera.opened + camera.mapped + camera.streaming, 0);
}

TEST(VideoDevice, RowsMayBeLonger) {
    FakeCamera camera;
    camera.stride = 6;
    camera.pictures = {{kYuyv.substr(0, 4) + "ab" + kYuyv.substr(4)}};
    VideoDevice device("/dev/video9", 2, 2, camera.calls());
    EXPECT_EQ(device.next().rgb[6], 208);
}

TEST(VideoDevice, TakesTheNewestAndGivesTheOthersBack) {
    FakeCamera camera;
    const std::string grey("\x7e\x80\x7e\x80\x7e\x80\x7e\x80", 8);
    VideoDevice device("/dev/video9", 2, 2, camera.calls());
    for (int round = 0; round < 5; ++round) {  // more pictures than buffers: none may be lost
        camera.pictures = {{kYuyv}, {kYuyv}, {grey}};
        EXPECT_EQ(device.next().rgb[0], 128);
        EXPECT_EQ(camera.queued.size(), 4u);
    }
}

TEST(VideoDevice, PassesOverDamagedPictures) {
    FakeCamera camera;
    camera.pictures = {{kYuyv}, {kYuyv, V4L2_BUF_FLAG_ERROR | V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC}};
    VideoDevice device("/dev/video9", 2, 2, camera.calls());
    EXPECT_EQ(device.next().rgb[0], 255);
    camera.pictures = {{kYuyv.substr(0, 5)}};  // cut short
    EXPECT_THROW((void)device.next(std::chrono::milliseconds(1)), IoError);
    EXPECT_EQ(camera.queued.size(), 4u);
}

TEST(VideoDevice, AsksForNoLongerThanItMay) {
    FakeCamera camera;
    VideoCalls calls = camera.calls();
    calls.wait = [](int, int) { return 1; };  // there is a picture, says the driver, and has none
    VideoDevice device("/dev/video9", 2, 2, calls);
    EXPECT_FALSE(device.poll(std::chrono::milliseconds(5)).has_value());
    camera.pictures = {{kYuyv.substr(0, 5)}};
    EXPECT_FALSE(device.poll(std::chrono::milliseconds(5)).has_value()) << "damaged";
    camera.pictures = {{kYuyv}};
    EXPECT_TRUE(device.poll(std::chrono::milliseconds(5)).has_value());
    std::array<int, 2> ends;
    ASSERT_EQ(pipe(ends.data()), 0);
    close(ends[1]);
    EXPECT_EQ(systemVideoCalls().wait(ends[0], 1000), -1) << "nothing more will ever come";
    close(ends[0]);
}

TEST(VideoDevice, PrefersJpeg) {
    FakeCamera camera;
    camera.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG};
    camera.width = 16, camera.height = 8;
    const std::vector<std::byte> jpeg = samples::tinyJpeg();
    camera.pictures = {{std::string(reinterpret_cast<const char*>(jpeg.data()), jpeg.size())}};
    VideoDevice device("/dev/video9", 16, 8, camera.calls());
    const TexturePicture picture = device.next();
    EXPECT_EQ(picture.width, 16);
    EXPECT_NEAR(picture.rgb[0], 200, 8);
}

TEST(VideoDevice, NamesWhatIsWrong) {
    FakeCamera silent, gone, other, none, still;
    EXPECT_EQ(problemOf(silent), "/dev/video9: no picture comes");
    gone.error_of_dequeue = ENODEV;
    EXPECT_THAT(problemOf(gone), HasSubstr("the camera is gone"));
    other.formats = {V4L2_PIX_FMT_GREY};
    EXPECT_EQ(problemOf(other), "/dev/video9: sends neither MJPEG nor YUYV");
    none.formats = {};
    EXPECT_EQ(problemOf(none), "/dev/video9: sends neither MJPEG nor YUYV");
    still.capabilities = V4L2_CAP_VIDEO_OUTPUT;
    EXPECT_EQ(problemOf(still), "/dev/video9: takes no pictures, or cannot stream them");
    EXPECT_THROW(VideoDevice("/dev/null", 640, 480), Unsupported);  // the operating system's own calls
    EXPECT_THROW(VideoDevice("/nowhere/video0", 640, 480), IoError);
}

}  // namespace
}  // namespace penumbra::test_video_device
