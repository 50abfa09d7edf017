// SPDX-License-Identifier: MIT
//
// Soft shadows in one file: a ray tracer of balls on a floor, and a light mesh. Writes minimal.ppm.
//     g++ -std=c++20 -O2 -I include examples/minimal/minimal.cpp -o minimal && ./minimal
#include <lightmesh/lightmesh.hpp>

#include <glm/glm.hpp>

#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

using glm::vec3;

struct Ball {
    vec3 middle;
    float radius;
    vec3 colour;
};

// A ring of balls on the floor z = 0, and one that hovers.
std::vector<Ball> make_balls() {
    std::vector<Ball> balls{{vec3(0.0f, 0.0f, 2.4f), 0.9f, vec3(0.9f)}};
    for (int i = 0; i < 9; ++i) {
        const float angle = 0.698f * static_cast<float>(i);
        const vec3 colour = 0.55f + 0.4f * glm::cos(angle + vec3(0.0f, -2.1f, 2.1f));
        balls.push_back({{3.0f * std::cos(angle), 3.0f * std::sin(angle), 0.7f}, 0.7f, colour});
    }
    return balls;
}

// The place where a ray first crosses a ball's surface, as a multiple of `way`; infinity if it does not.
float distance_to(const Ball& ball, const vec3& origin, const vec3& way) {
    const vec3 to_middle = ball.middle - origin;
    const float a = glm::dot(way, way), b = glm::dot(way, to_middle);
    const float square = b * b - a * (glm::dot(to_middle, to_middle) - ball.radius * ball.radius);
    if (square >= 0.0f)
        for (const float t : {(b - std::sqrt(square)) / a, (b + std::sqrt(square)) / a})
            if (t > 0.0f)
                return t;
    return std::numeric_limits<float>::infinity();
}

// The adapter: all that a light mesh has to know of a ray tracer. All lamps hang above the floor.
struct Tracer {
    const std::vector<Ball>* balls;

    bool occluded(const lightmesh::Segment& segment) const {
        for (const Ball& ball : *balls)
            if (distance_to(ball, segment.origin, segment.target - segment.origin) < 1.0f)
                return true;
        return false;
    }
};

int main() {
    const std::vector<Ball> balls = make_balls();
    const std::vector<lightmesh::PointLight> lamps{{{-6, -4, 7}}, {{6, -3, 8}}, {{1, 7, 9}}};
    const std::vector<lightmesh::Light> lights(lamps.begin(), lamps.end());
    const lightmesh::LightMesh mesh{Tracer{&balls}, lights,
                                    lightmesh::Settings{.radius = 0.6f, .quality = 5.0f}};

    constexpr int width = 640, height = 400;
    const vec3 eye(0.0f, -10.0f, 6.0f), ahead(0.0f, 0.88f, -0.475f), up(0.0f, 0.475f, 0.88f);
    std::string pixels;
    std::vector<float> visibility(lights.size());
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const vec3 right(static_cast<float>(x - width / 2) / 600.0f, 0.0f, 0.0f);
            const vec3 way = ahead + right + up * (static_cast<float>(height / 2 - y) / 600.0f);
            float t = -eye.z / way.z;  // the floor
            vec3 normal(0.0f, 0.0f, 1.0f), colour(0.75f);
            for (const Ball& ball : balls) {
                if (const float hit = distance_to(ball, eye, way); hit < t) {
                    t = hit;
                    normal = (eye + hit * way - ball.middle) / ball.radius;
                    colour = ball.colour;
                }
            }
            const vec3 point = eye + t * way;
            mesh.visibility(point, normal, visibility);  // How lit is the point by each light?
            float light = 0.05f;
            for (std::size_t i = 0; i < lights.size(); ++i) {
                const vec3 to_light = lamps[i].position - point;
                const float facing = glm::max(glm::dot(normal, to_light), 0.0f);
                light += 30.0f * visibility[i] * facing / std::pow(glm::length(to_light), 3.0f);
            }
            for (int i = 0; i < 3; ++i) {
                const float value = std::pow(glm::min(light * colour[i], 1.0f), 1.0f / 2.2f);
                pixels += static_cast<char>(static_cast<unsigned char>(255.0f * value));
            }
        }
    }
    std::ofstream file("minimal.ppm", std::ios::binary);
    file << "P6\n" << width << ' ' << height << "\n255\n" << pixels;
    return file.flush() ? 0 : 1;
}
