//! Processes for tests: one that hands back every kind of thing, others that misbehave.

use biotope::codec::colours::ColourMap;
use biotope::codec::map::Georeference;
use biotope::codec::map::Legend;
use biotope::codec::map::Map;
use biotope::codec::map::MapData;
use biotope::codec::map::Scale;
use biotope::codec::map::Spread;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::jobs::Artefact;
use biotope::jobs::Description;
use biotope::jobs::Estimate;
use biotope::jobs::Failure;
use biotope::jobs::Hasher;
use biotope::jobs::Invalid;
use biotope::jobs::Job;
use biotope::jobs::JobContext;
use biotope::jobs::Output;
use biotope::jobs::Process;
use biotope::jobs::Sources;
use biotope::jobs::Stage;
use biotope::jobs::Table;
use biotope::jobs::artefact::Kind;
use biotope::jobs::echo::Echo;
use biotope::jobs::process::ASYNC;
use biotope::jobs::process::inputs_schema;
use biotope::jobs::schema::read;
use biotope_api::error::ErrorCode;
use biotope_api::reference::Reference;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use bytes::Bytes;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;
use serde_json::json;

pub fn all() -> Vec<Box<dyn Process>> {
    vec![Box::new(Echo), Box::new(Zoo), Box::new(Trouble)]
}

/// Hands back one of every kind of thing, drawn over the bytes of a reference.
pub struct Zoo;

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ZooInputs {
    /// Bytes to draw.
    terrain: Reference,
    /// Seed.
    #[serde(default)]
    seed: u64,
}

struct ZooJob {
    inputs: ZooInputs,
    bytes: Bytes,
}

impl Process for Zoo {
    fn description(&self) -> Description {
        let output = |id, kind| Output::new(id, "An output", "Of a test.", kind);
        Description {
            id: "zoo",
            title: "Zoo",
            text: "One of every kind of thing.",
            version: "1",
            keywords: &[],
            control: ASYNC,
            inputs: inputs_schema::<ZooInputs>(),
            outputs: vec![
                output("maps.<slug>", Kind::Map).in_unit("m"),
                output("herds", Kind::Table),
                output("rag", Kind::Tables),
                output("summary", Kind::Json),
                output("tracks.bin", Kind::file("application/octet-stream", "bin")),
                output("extra", Kind::Json).on_request(),
            ],
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: ZooInputs = read(inputs)?;
        let source = sources.open(&inputs.terrain).map_err(|error| error.at("/terrain"))?;
        let bytes = match source.map() {
            Some(map) => Bytes::from(format!("a map of {} cells", map.grid().len())),
            None => source.bytes().map(|(_, bytes)| bytes.clone()).unwrap_or_default(),
        };
        if bytes.is_empty() {
            return Err(Invalid::new("/terrain", ErrorCode::Unreadable, "some bytes", "none"));
        }
        Ok(Box::new(ZooJob { inputs, bytes }))
    }
}

impl Job for ZooJob {
    fn estimate(&self) -> Estimate {
        Estimate { memory_bytes: 1 << 20 }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).expect("plain data")
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let inputs = Hasher::new().part("bytes", &self.bytes).finish();
        let stage = Stage { name: "heights", version: 1, inputs };
        let heights = match context.recall(stage)? {
            Some(heights) => heights,
            None => {
                context.remember(stage, self.bytes.clone())?;
                self.bytes.clone()
            }
        };
        let grid = Grid::new(8, 4, 10.0);
        let value = |i: usize| f32::from(heights[i % heights.len()]) + i as f32;
        let data = MapData::F32(Raster { grid, data: (0..grid.len()).map(value).collect() });
        let scale = Scale::Continuous { range: None, colours: ColourMap::Viridis, spread: Spread::Linear };
        let legend = Legend { title: "Heights".into(), unit: "m".into(), scale };
        context.put("maps.height", Artefact::Map(Map { data, legend, georeference: Georeference::default() }))?;
        let table = Table::new().integers("herd", "", [0, 1]).numbers("x", "m", [0.5, 1.5]);
        context.put("herds", Artefact::Table(table.clone()))?;
        context.put("rag", Artefact::Tables(vec![("nodes".into(), table.clone()), ("edges".into(), table)]))?;
        context.put("summary", Artefact::Json(json!({ "seed": context.seed, "<b>": "<i>" })))?;
        let file = Artefact::Bytes {
            media_type: "application/octet-stream".into(),
            extension: "bin".into(),
            bytes: Bytes::from_static(b"0123456789"),
        };
        context.put("tracks.bin", file)?;
        context.put("extra", Artefact::Json(json!("asked for")))?;
        context.cite("bison.mass", "T table A.2");
        context.warn(Warning::new(WarningCode::EightBit, "/terrain", "The ground shows steps.").with_count(3));
        Ok(())
    }
}

/// Misbehaves in the way asked for.
pub struct Trouble;

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
struct TroubleInputs {
    /// What goes wrong.
    kind: TroubleKind,
    /// Memory it claims to need.
    #[serde(default)]
    memory_bytes: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum TroubleKind {
    Panic,
    Invalid,
    Fault,
    Parse,
    Undescribed,
    Fine,
    Forever,
}

struct TroubleJob(TroubleInputs);

impl Process for Trouble {
    fn description(&self) -> Description {
        Description {
            id: "trouble",
            title: "Trouble",
            text: "Misbehaves.",
            version: "1",
            keywords: &[],
            control: ASYNC,
            inputs: inputs_schema::<TroubleInputs>(),
            outputs: Vec::new(),
        }
    }

    fn parse(&self, inputs: Value, _: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: TroubleInputs = read(inputs)?;
        if inputs.kind == TroubleKind::Parse {
            let mut faults = Invalid::new("/kind", ErrorCode::NotOneOf, "something else", "parse");
            faults.push("/kind", ErrorCode::Inconsistent, "peace", "trouble");
            return Err(faults);
        }
        Ok(Box::new(TroubleJob(inputs)))
    }
}

impl Job for TroubleJob {
    fn estimate(&self) -> Estimate {
        Estimate { memory_bytes: self.0.memory_bytes }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.0).expect("plain data")
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        match self.0.kind {
            TroubleKind::Panic => panic!("a secret of the house"),
            TroubleKind::Invalid => {
                Err(Invalid::new("/kind", ErrorCode::Inconsistent, "something that works", "this").into())
            }
            TroubleKind::Fault => Err(Failure::Fault("a secret of the house".into())),
            TroubleKind::Undescribed => context.put("undescribed", Artefact::Json(Value::Null)),
            TroubleKind::Fine | TroubleKind::Parse => Ok(()),
            TroubleKind::Forever => loop {
                context.run.progress("forever", 1, 2)?;
                std::thread::sleep(std::time::Duration::from_millis(5));
            },
        }
    }
}
