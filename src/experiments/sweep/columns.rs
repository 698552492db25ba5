//! Results with typed columns, for data frames.

use super::Row;
use crate::error::{Error, Result};
use crate::output::write_whole;
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::Result as ParquetResult;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// The names of the columns of [`Row`], in their order.
pub(super) const NAMES: [&str; 20] = [
    "set",
    "scenario",
    "p",
    "k",
    "s_max",
    "guess",
    "k_cons",
    "c_cons",
    "outcome",
    "reason",
    "final_error_inf",
    "open_loop_error_inf",
    "control_effort",
    "action",
    "dynamics_defect",
    "smallest_clearance_m",
    "steps",
    "omega_evaluations",
    "jacobian_evaluations",
    "solve_seconds",
];

/// The values of a column, any of which may be missing.
enum Column {
    Count(Vec<Option<i64>>),
    Real(Vec<Option<f64>>),
    Text(Vec<Option<ByteArray>>),
}

/// The columns of [`NAMES`].
fn columns(rows: &[Row]) -> [Column; 20] {
    let count = |f: fn(&Row) -> Option<usize>| {
        Column::Count(rows.iter().map(|r| f(r).map(|x| x as i64)).collect())
    };
    let real = |f: fn(&Row) -> Option<f64>| Column::Real(rows.iter().map(f).collect());
    let text = |f: fn(&Row) -> Option<String>| {
        let values = rows.iter().map(|r| f(r).map(|t| t.as_str().into()));
        Column::Text(values.collect())
    };
    [
        count(|r| Some(r.set)),
        text(|r| Some(r.scenario.clone())),
        count(|r| Some(r.p)),
        real(|r| Some(r.k)),
        real(|r| Some(r.s_max)),
        text(|r| Some(r.guess.to_string())),
        real(|r| r.k_cons),
        real(|r| r.c_cons),
        text(|r| Some(r.outcome.name().to_owned())),
        text(|r| r.reason.clone()),
        real(|r| r.final_error_inf),
        real(|r| r.open_loop_error_inf),
        real(|r| r.control_effort),
        real(|r| r.action),
        real(|r| r.dynamics_defect),
        real(|r| r.smallest_clearance_m),
        count(|r| r.steps),
        count(|r| r.omega_evaluations),
        count(|r| r.jacobian_evaluations),
        real(|r| Some(r.solve_seconds)),
    ]
}

/// Writes rows as a Parquet file, which data frames of any language read.
///
/// # Errors
/// The file cannot be written.
pub fn write_parquet(rows: &[Row], path: &Path) -> Result<()> {
    let bytes = encode(rows).map_err(|e| Error::io(path, io::Error::other(e)))?;
    write_whole(path, |file| file.write_all(&bytes))
}

fn encode(rows: &[Row]) -> ParquetResult<Vec<u8>> {
    let columns = columns(rows);
    let fields = NAMES.iter().zip(&columns).map(|(name, column)| {
        let (physical, converted) = match column {
            Column::Count(_) => (Physical::INT64, ConvertedType::NONE),
            Column::Real(_) => (Physical::DOUBLE, ConvertedType::NONE),
            Column::Text(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
        };
        let field = Type::primitive_type_builder(name, physical);
        let field = field.with_repetition(Repetition::OPTIONAL);
        Ok(Arc::new(field.with_converted_type(converted).build()?))
    });
    let schema = Type::group_type_builder("sweep")
        .with_fields(fields.collect::<ParquetResult<_>>()?)
        .build()?;
    let mut bytes = Vec::new();
    let mut file = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Default::default())?;
    let mut group = file.next_row_group()?;
    for column in &columns {
        let Some(mut writer) = group.next_column()? else {
            break;
        };
        match (writer.untyped(), column) {
            (ColumnWriter::Int64ColumnWriter(w), Column::Count(x)) => {
                w.write_batch(&present(x), Some(&levels(x)), None)?;
            }
            (ColumnWriter::DoubleColumnWriter(w), Column::Real(x)) => {
                w.write_batch(&present(x), Some(&levels(x)), None)?;
            }
            (ColumnWriter::ByteArrayColumnWriter(w), Column::Text(x)) => {
                w.write_batch(&present(x), Some(&levels(x)), None)?;
            }
            _ => return Err(parquet::errors::ParquetError::General("column type".into())),
        }
        writer.close()?;
    }
    group.close()?;
    file.close()?;
    Ok(bytes)
}

/// The values that are there.
fn present<T: Clone>(values: &[Option<T>]) -> Vec<T> {
    values.iter().flatten().cloned().collect()
}

/// 1 where a value is there and 0 where none is.
fn levels<T>(values: &[Option<T>]) -> Vec<i16> {
    values.iter().map(|x| i16::from(x.is_some())).collect()
}
