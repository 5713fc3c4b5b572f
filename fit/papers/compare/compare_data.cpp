#include <cmath>
#include <nlohmann/json.hpp>

#include "fit/papers/compare/compare_output.h"
#include "fit/papers/compare/paper_forms.h"

namespace penumbra {

namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN, so a figure that is not known is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json numbers(const std::vector<double>& values) {
    Json list = Json::array();
    for (double value : values) list.push_back(number(value));
    return list;
}

// Returns the columns of the CSV file, which are the members of a fit in JSON, in this order.
Json fitJson(const CompareFit& fit) {
    const FitOptions& options = fit.options;
    const FitReport& report = fit.report;
    return {{"model", options.fields.empty() ? nameOf(options.model) : "composed"},
            {"features", nameOf(options.features)},
            {"clusters", fit.clusters},
            {"input_variance", inputVariance(options)},
            {"output_variance", options.output_variance},
            {"convention", options.convention.name()},
            {"target", options.form == &kCosineForm ? "cosine-weighted" : "visibility"},
            {"frame", options.form == &kModelFrameForm ? "model" : "local"},
            {"clamped", options.form->clamp ? "yes" : "no"},
            {"train_relative_error", number(report.train.relative_error)},
            {"train_rms_v", number(report.train.rms_v)},
            {"train_ambient_error", number(report.train.ambient_error)},
            {"held_out_relative_error", number(report.held_out.relative_error)},
            {"held_out_rms_v", number(report.held_out.rms_v)},
            {"held_out_ambient_error", number(report.held_out.ambient_error)},
            {"cross_validated_relative_error", number(report.cross_validated_error)},
            {"output_pca_relative_error", number(report.output_floor)},
            {"inputs_per_cluster", fit.inputs},
            {"components_per_cluster", fit.components},
            {"bytes_per_vertex", fit.bytes_per_vertex},
            {"fit_seconds", fit.fit_seconds},
            {"evaluate_milliseconds", fit.evaluate_milliseconds},
            {"prior", options.prior ? "cross-validated" : "none"},
            {"held_out_cosine_product_error", number(fit.cosine_product_error)}};
}

// Returns the same columns for a fit of a feature vector. What is not measured of it is null.
Json fitJson(const VectorFit& fit, const CompareOptions& options) {
    CompareFit row;
    row.options = referenceFit(options, ModelKind::kLinear, fit.features);
    row.options.form = &kUnclampedForm;
    row.options.prior = fit.prior;
    row.report.train = fit.train;
    row.report.held_out = fit.held_out;
    row.clusters = fit.clusters;
    row.inputs = fit.inputs;
    row.components = fit.components;
    row.bytes_per_vertex = fit.bytes_per_vertex;
    Json json = fitJson(row);
    json["model"] = std::string(nameOfDegree(fit.degree)) + " feature vector";
    for (const char* name : {"train_ambient_error", "held_out_ambient_error", "cross_validated_relative_error",
                             "output_pca_relative_error", "fit_seconds", "evaluate_milliseconds"})
        json[name] = nullptr;
    return json;
}

// Returns a row for each fit, those of feature vectors last.
std::vector<Json> fitRows(const Comparison& comparison) {
    std::vector<Json> rows;
    for (const CompareFit& fit : comparison.fits) rows.push_back(fitJson(fit));
    for (const VectorFit& fit : comparison.vectors) rows.push_back(fitJson(fit, comparison.options));
    return rows;
}

Json axisJson(const Axis& axis) {
    Json json{{"label", axis.label}, {"log", axis.log}};
    if (!axis.names.empty()) json["names"] = axis.names;
    return json;
}

Json plotJson(const Plot& plot) {
    Json json{{"id", plot.id},         {"title", plot.title},   {"kind", plot.bars ? "bars" : "lines"},
              {"x", axisJson(plot.x)}, {"y", axisJson(plot.y)}, {"series", Json::array()}};
    for (const Series& series : plot.series) {
        json["series"].push_back({{"name", series.name}, {"x", numbers(series.x)}, {"y", numbers(series.y)}});
        if (!series.spread.empty()) json["series"].back()["deviation"] = numbers(series.spread);
    }
    return json;
}

Json figureJson(const Figure& figure) {
    Json json{{"id", figure.id},
              {"title", figure.title},
              {"source", figure.source},
              {"finding", figure.finding},
              {"method", figure.method},
              {"plots", Json::array()},
              {"table", {{"columns", figure.table.columns}, {"rows", figure.table.rows}}}};
    for (const Plot& plot : figure.plots) json["plots"].push_back(plotJson(plot));
    return json;
}

// Appends a row, and sets the header to its names.
void addRow(const Json& json, std::string& header, std::string& rows) {
    std::string names, values;
    for (const auto& [name, value] : json.items()) {
        names += (names.empty() ? "" : ",") + name;
        const std::string text = value.is_string() ? value.get<std::string>() : value.is_null() ? "" : value.dump();
        // A name such as PCA(8,22) has a comma.
        values += (values.empty() ? "" : ",") + (text.find(',') == std::string::npos ? text : '"' + text + '"');
    }
    header = names + "\n";
    rows += values + "\n";
}

Json runJson(const TransferRun& run) {
    return {{"model", run.name},
            {"linear_transfer", run.of_paper ? "yes" : "no"},
            {"prior", run.regularised ? "yes" : "no"},
            {"alpha", number(run.alpha)},
            {"bytes", run.bytes},
            {"megaops", run.megaops},
            {"fit_seconds", run.fit_seconds},
            {"pca_seconds", run.pca_seconds},
            {"frame_milliseconds", run.frame_ms},
            {"train_transfer_error", number(run.train.transfer_error)},
            {"held_out_transfer_error", number(run.held_out.transfer_error)},
            {"train_relative_transfer_error", number(run.train.relative_transfer_error)},
            {"held_out_relative_transfer_error", number(run.held_out.relative_transfer_error)},
            {"train_relative_error", number(run.train.relative_error)},
            {"held_out_relative_error", number(run.held_out.relative_error)},
            {"train_local_relative_error", number(run.local_train)},
            {"held_out_local_relative_error", number(run.local_held_out)}};
}

std::vector<Json> runRows(const TransferComparison& comparison) {
    std::vector<Json> rows;
    for (const TransferRun& run : comparison.runs) rows.push_back(runJson(run));
    return rows;
}

// Joins what is told of one kind of comparison to what both tell.
std::string wholeJson(const char* schema, const Json& own, const char* name_of_rows, const std::vector<Json>& rows,
                      const std::vector<Figure>& figures, const CompareSource& source) {
    Json json{{"schema", schema},
              {"schema_version", kCompareVersion},
              {"provenance", Json::parse(toJson(source.provenance))}};
    json.update(own);
    json["train_clips"] = source.train_clips;
    json["held_out_clips"] = source.held_out_clips;
    json["train_frames"] = source.train_frames;
    json["held_out_frames"] = source.held_out_frames;
    json[name_of_rows] = rows;
    json["figures"] = Json::array();
    for (const Figure& figure : figures) json["figures"].push_back(figureJson(figure));
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// The names of the first row are those of all.
std::string csvOf(const std::vector<Json>& rows) {
    std::string header, lines;
    for (const Json& row : rows) addRow(row, header, lines);
    return header + lines;
}

}  // namespace

std::string compareJson(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source) {
    return wholeJson("penumbra.compare", {{"vertices", source.vertices}, {"joints", source.joints}}, "fits",
                     fitRows(comparison), figures, source);
}

std::string compareCsv(const Comparison& comparison) { return csvOf(fitRows(comparison)); }

std::string transferJson(const TransferComparison& comparison, const std::vector<Figure>& figures,
                         const CompareSource& source) {
    return wholeJson(
        "penumbra.compare_transfer",
        {{"order", comparison.options.order}, {"vertices", comparison.vertices}, {"angles", comparison.angles}},
        "models", runRows(comparison), figures, source);
}

std::string transferCsv(const TransferComparison& comparison) { return csvOf(runRows(comparison)); }

}  // namespace penumbra
