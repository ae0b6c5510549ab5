//! `echo`: answers its input, after an optional pause. The smallest process, to try clients with
//! and to see what a process looks like.

use std::time::Duration;
use std::time::Instant;

use biotope_api::echo::EchoInputs;
use serde_json::Value;

use crate::jobs::Artefact;
use crate::jobs::Description;
use crate::jobs::Estimate;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Output;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::artefact::Kind;
use crate::jobs::process::QUICK;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct Echo;

impl Process for Echo {
    fn description(&self) -> Description {
        Description {
            id: "echo",
            title: "Echo",
            text: "Answers its input, after an optional pause: for trying clients out.",
            version: "1",
            keywords: &["test"],
            control: QUICK,
            inputs: inputs_schema::<EchoInputs>(),
            outputs: vec![Output::new("value", "Value", "The value given, unchanged.", Kind::Json)],
        }
    }

    fn parse(&self, inputs: Value, _sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: EchoInputs = read(inputs)?;
        Ok(Box::new(EchoJob { inputs }))
    }
}

/// The job: its inputs need no more parsing than their type gives.
struct EchoJob {
    inputs: EchoInputs,
}

impl Job for EchoJob {
    fn estimate(&self) -> Estimate {
        Estimate { memory_bytes: 1 << 20 }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        self.pause(context)?;
        context.put("value", Artefact::Json(self.inputs.value))
    }
}

impl EchoJob {
    /// Waits in steps of a twentieth of a second, so that it can be stopped.
    fn pause(&self, context: &JobContext<'_>) -> Result<(), Failure> {
        let (start, pause) = (Instant::now(), Duration::from_secs_f64(self.inputs.pause_s));
        let millis = |time: Duration| u64::try_from(time.as_millis()).unwrap_or(u64::MAX);
        while let Some(left) = pause.checked_sub(start.elapsed()).filter(|left| !left.is_zero()) {
            context.run.progress("pause", millis(pause - left), millis(pause))?;
            std::thread::sleep(left.min(Duration::from_millis(50)));
        }
        Ok(context.run.progress("pause", millis(pause), millis(pause))?)
    }
}
