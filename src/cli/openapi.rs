//! `openapi`: the document of the API.

use clap::Args;
use clap::ValueEnum;

use crate::cli::CliError;
use crate::cli::say;
use crate::http::openapi::Documents;
use crate::jobs::registry::Registry;

/// Prints the document of the API.
#[derive(Debug, Args)]
pub struct OpenApi {
    /// Version of OpenAPI.
    #[arg(long, value_enum, default_value = "3.1")]
    version: Version,
    /// How it is written. 3.0 is written as JSON only.
    #[arg(long, value_enum, default_value = "json")]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Version {
    #[value(name = "3.0")]
    V3_0,
    #[value(name = "3.1")]
    V3_1,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Json,
    Yaml,
}

impl OpenApi {
    /// Prints it.
    pub fn execute(self) -> Result<(), CliError> {
        let registry = Registry::standard().map_err(CliError::Failed)?;
        let documents = Documents::new(&registry);
        let text = match (self.version, self.format) {
            (Version::V3_1, Format::Yaml) => documents.yaml().to_owned(),
            (Version::V3_1, Format::Json) => format!("{:#}", documents.v3_1()),
            (Version::V3_0, Format::Json) => format!("{:#}", documents.v3_0()),
            (Version::V3_0, Format::Yaml) => return Err(CliError::Usage("--format yaml needs --version 3.1".into())),
        };
        say(text.trim_end());
        Ok(())
    }
}
